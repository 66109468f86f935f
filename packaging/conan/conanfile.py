"""Conan 2: `conan create packaging/conan` packs the checkout that this file lies in."""

import os

from conan import ConanFile
from conan.tools.files import copy
from conan.tools.layout import basic_layout


class HTree(ConanFile):
    name = "htree"
    version = "0.1.0"
    license = "MIT"
    description = "Ray queries over triangle meshes, by hierarchies cheap enough to build for every frame"
    topics = ("ray tracing", "geometry", "bvh")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False]}
    default_options = {"shared": False}

    def configure(self):
        self.settings.rm_safe("compiler.cppstd")
        self.settings.rm_safe("compiler.libcxx")

    def layout(self):
        basic_layout(self)

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..")
        for pattern in ("Makefile", "LICENSE", "README.md", "CHANGELOG.md", "include/*", "lib/*", "cl/*",
                        "packaging/*", "examples/*", "bindings/bindings.mk", "bindings/cpp/include/*"):
            copy(self, pattern, root, self.export_sources_folder)

    def _make(self, target):
        # The library alone: programs need more packages, OpenCL its headers.
        self.run(f'make {target} PROGRAMS= HAVE_OPENCL= PREFIX="{self.package_folder}"', cwd=self.source_folder)

    def build(self):
        self._make("lib")

    def package(self):
        self._make("install")
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        for name in os.listdir(os.path.join(self.package_folder, "lib")):
            if name.endswith(".a") if self.options.shared else ".so" in name:
                os.remove(os.path.join(self.package_folder, "lib", name))

    def package_info(self):
        self.cpp_info.libs = ["htree"]
        self.cpp_info.set_property("pkg_config_name", "htree")
        self.cpp_info.set_property("cmake_file_name", "htree")
        self.cpp_info.set_property("cmake_target_name", "htree::htree")
        if not self.options.shared:
            self.cpp_info.system_libs = ["m", "pthread"]
