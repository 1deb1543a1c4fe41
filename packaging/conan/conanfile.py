# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Recipe of Conan 2 for the library in C++, against the OpenCV of the system: scripts/package.sh --conan."""

import os
import re

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load, rmdir
from conan.tools.system.package_manager import Apt, Brew

required_conan_version = '>=2.0'


class Aqorb(ConanFile):
    name = 'aqorb'
    description = 'ORB features spread uniformly over the image, a drop-in for cv::ORB'
    license = 'Apache-2.0'
    topics = 'opencv', 'orb', 'features', 'slam', 'computer-vision'
    package_type = 'library'
    settings = 'os', 'arch', 'compiler', 'build_type'
    options = {'shared': [True, False], 'fPIC': [True, False]}
    default_options = {'shared': False, 'fPIC': True}
    implements = ['auto_shared_fpic']

    def root(self):
        return os.path.dirname(os.path.dirname(self.recipe_folder))

    def set_version(self):
        self.version = re.search(r'project\(aqorb VERSION ([\d.]+)', load(self, os.path.join(self.root(), 'CMakeLists.txt')))[1]

    def export_sources(self):
        copy(self, 'CMakeLists.txt', self.root(), self.export_sources_folder)
        copy(self, 'LICENSE', self.root(), self.export_sources_folder)
        copy(self, 'cmake/*', self.root(), self.export_sources_folder)
        for part in 'CMakeLists.txt', 'include/*', 'src/*':
            copy(self, 'modules/aqorb/' + part, self.root(), self.export_sources_folder)

    def system_requirements(self):
        Apt(self).install(['libopencv-dev'])
        Brew(self).install(['opencv'])

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for part in 'TESTS', 'SAMPLES', 'PRELOAD':
            toolchain.cache_variables['AQORB_BUILD_' + part] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, 'LICENSE', self.source_folder, os.path.join(self.package_folder, 'licenses'))
        CMake(self).install()
        rmdir(self, os.path.join(self.package_folder, 'lib', 'pkgconfig'))  # which holds for the system's prefixes only

    def package_info(self):
        # The CMake package that the project installs, which finds OpenCV.
        self.cpp_info.set_property('cmake_find_mode', 'none')
        self.cpp_info.builddirs = ['lib/cmake/aqorb']
        self.cpp_info.libs = ['aqorb']
