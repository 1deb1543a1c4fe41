#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Detects the features of all images in a folder, as aqorb extract does, by a pipeline of Ray Data: on this machine,
or on the cluster whose address is given. The result is a folder of parts, as aqorb extract writes them, with the same
rows. Files that are no images are named in the log. Needs aqorb-photographs and ray[data], on each machine of a cluster."""

import argparse
import functools
import io
import logging
import os
import sys

try:
    import pyarrow as pa
    import ray
    import ray.data
except ImportError as error:
    sys.exit(f"{error}. This sample also needs: pip install 'ray[data]'")

import aqorb
from aqorb_photographs import images, store


class Extractor:
    """Holds a detector. An actor of Ray works on a batch of files at a time."""

    def __init__(self, folder, options):
        self.folder = folder
        self.how = images.Reading(options.max_size, not options.ignore_orientation)
        self.detector = aqorb.AdaptiveQuadtreeORB_create(options.num_features)
        aqorb.setNumThreads(1)  # an actor has a processor

    def __call__(self, batch):
        files = []
        for path, content in zip(batch['path'].to_pylist(), batch['bytes']):
            # Ray does not say the time of a file: where all machines have the folder, the file does.
            time = os.stat(path).st_mtime_ns if os.path.exists(path) else None
            name = store.name_of(path.split('://')[-1], self.folder.split('://')[-1])
            files.append(store.File(name, functools.partial(io.BytesIO, content.as_buffer()), self.folder,
                                    len(content.as_buffer()), time))
        rows = [store.FEATURES.empty_table()]
        for file, row, note in store.extract(files, self.detector, self.how):
            if row is None:
                logging.getLogger('ray.data').warning('%s is left out: %s', file.name, note)
            else:
                rows.append(row)
        return pa.concat_tables(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--address', help='address of a cluster, such as auto or ray://head:10001; this machine by default')
    parser.add_argument('--out', required=True, metavar='FOLDER', help='new folder for the result')
    parser.add_argument('--actors', type=int, default=os.cpu_count(), help='one for each processor (%(default)s)')
    parser.add_argument('--batch', type=int, default=64, help='files that an actor takes at a time (%(default)s)')
    parser.add_argument('--num-features', type=int, default=1000)
    parser.add_argument('--max-size', type=int)
    parser.add_argument('--ignore-orientation', action='store_true')
    parser.add_argument('folder', metavar='IMAGES', help='folder or bucket that all machines can read')
    options = parser.parse_args()
    if os.path.exists(options.out):
        sys.exit(f'{options.out} exists')
    ray.init(options.address)
    folder = options.folder if '://' in options.folder else os.path.abspath(options.folder)
    # Reading and writing wait for disks or the network. Without a share for them, actors would take all processors.
    waiting = {'num_cpus': .25}
    files = ray.data.read_binary_files(folder, include_paths=True, ray_remote_args=waiting)
    features = files.map_batches(Extractor, fn_constructor_args=(folder, options), batch_size=options.batch,
                                 batch_format='pyarrow', zero_copy_batch=True,
                                 num_cpus=.75, max_restarts=-1, max_task_retries=-1,
                                 compute=ray.data.ActorPoolStrategy(size=options.actors, max_tasks_in_flight_per_actor=2))
    features.write_parquet(options.out, ray_remote_args=waiting)


if __name__ == '__main__':
    main()
