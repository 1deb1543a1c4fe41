# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""How every sample takes its arguments, reads and writes images, and ends: the same as program.hpp.

aqorb is the package aqorb (scripts/python.sh builds it) or the module of a cv2 that was built with it
(scripts/opencv.sh builds one)."""

import argparse
import os
import sys

# One sentence is enough if something fails. OpenCV and FFmpeg would add lines of their own.
os.environ.setdefault('OPENCV_LOG_LEVEL', 'SILENT')
os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')

NAME = os.path.basename(sys.argv[0])
FAILED = 1  # a file cannot be read or written, or there is no result
BAD_ARGUMENTS = 2  # as argparse
EPILOG = '''Exit code: 0 done; 1 a file cannot be read or written, or there is no result;
2 an argument is not accepted.'''

try:
    import cv2 as cv
    import numpy  # whose arrays cv2 takes and returns
    try:
        import aqorb
    except ImportError:
        from cv2 import aqorb
except ImportError as error:
    sys.exit('{}: {}. cv2, numpy, and either the package aqorb or a cv2 built with the module are needed; see '
             'README.md'.format(NAME, error))


class Failure(Exception):
    """Ends the program with one sentence."""

    def __init__(self, exit_code, message):
        super().__init__(message)
        self.exit_code = exit_code


class Program(argparse.ArgumentParser):
    """A program's command line: some files, and options."""

    def __init__(self, about, files, fewest, most, example):
        super().__init__(description=about, epilog='Example:\n  {}\n\n{}'.format(example, EPILOG), allow_abbrev=False,
                         usage='{} [OPTION ...] {}'.format(NAME, files),
                         formatter_class=argparse.RawDescriptionHelpFormatter)
        self.description_of_files, self.fewest, self.most = files, fewest, most

    def error(self, message):
        raise Failure(BAD_ARGUMENTS, message + '; see --help')

    def add_text(self, name, default, about):
        self.add_argument('--' + name, metavar='VALUE', default=default,
                          help='{} (default: {})'.format(about, default or 'none'))

    def add_flag(self, name, about):
        self.add_argument('--' + name, action='store_true', help=about)

    def add_whole_number(self, name, default, low, high, about):
        def whole_number(text):
            digits = text[1:] if text[:1] in ('-', '+') else text
            if not (digits.isdecimal() and digits.isascii() and low <= int(text) <= high):
                raise Failure(BAD_ARGUMENTS, '--{}={}: a whole number from {} to {} is accepted'.format(
                    name, text, low, high))
            return int(text)
        self.add_argument('--' + name, metavar='VALUE', type=whole_number, default=default,
                          help='{} (default: {})'.format(about, default))

    def add_feature_count(self, default=1000, name='nfeatures', about='number of keypoints to ask for'):
        self.add_whole_number(name, default, 1, 1000000, about)

    def parse(self):
        """The options, and the files as `files`."""
        arguments, others = self.parse_known_args()
        for other in others:
            if other.startswith('-') and len(other) > 1:
                raise Failure(BAD_ARGUMENTS, other + ': unknown option; see --help')
        if len(others) > self.most:
            raise Failure(BAD_ARGUMENTS, others[self.most] + ': one argument too many; see --help')
        if len(others) < self.fewest:
            raise Failure(BAD_ARGUMENTS, 'the arguments {} are needed; see --help'.format(self.description_of_files))
        arguments.files = others
        return arguments


def run(main):
    """Runs a program and ends with its exit code."""
    try:
        main()
    except Failure as failure:
        print('{}: {}'.format(NAME, failure), file=sys.stderr)
        sys.exit(failure.exit_code)
    except cv.error as failure:
        print('{}: {}'.format(NAME, failure), file=sys.stderr)
        sys.exit(FAILED)


def file_at(arguments, index, default):
    """The file of this index, or the default where there are fewer."""
    return arguments.files[index] if index < len(arguments.files) else default


def find_file(name):
    """The path of a file, or of one of OpenCV's sample files."""
    path = cv.samples.findFile(name, False, True)
    if not path:
        raise Failure(FAILED, name + ": no such file, nor one of OpenCV's samples in the folder that the variable "
                                     'OPENCV_SAMPLES_DATA_PATH names')
    return path


def require_size(name, image, smallest_side=32):
    """Ends the program where an image is too small to hold features."""
    height, width = image.shape[:2]
    if min(width, height) < smallest_side:
        raise Failure(FAILED, '{}: has {}x{} pixels; at least {}x{} are accepted'.format(
            name, width, height, smallest_side, smallest_side))


def read_image(name, flags=cv.IMREAD_GRAYSCALE, smallest_side=32):
    """Reads an image file, or one of OpenCV's sample images."""
    try:
        image = cv.imread(find_file(name), flags)
    except cv.error:  # larger than OpenCV reads
        image = None
    if image is None:
        raise Failure(FAILED, name + ': not an image that OpenCV can read')
    require_size(name, image, smallest_side)
    return image


def write_picture(path, picture, quality=85):
    """Writes a picture and says where it is."""
    try:
        written = cv.imwrite(path, picture, [cv.IMWRITE_JPEG_QUALITY, quality])
    except cv.error:  # no such format, or too large for it
        written = False
    if not written:
        raise Failure(FAILED, '{}: a picture of {}x{} pixels cannot be written there; a name in an existing folder '
                              'that ends in .png or .jpg is accepted'.format(path, *picture.shape[1::-1]))
    print('Picture:', os.path.realpath(path))


def path_in(folder, name):
    """The path of a file in an existing folder."""
    if not os.path.isdir(folder):
        raise Failure(FAILED, '--out={}: an existing folder is accepted'.format(folder))
    return os.path.join(folder, name)
