"""Puts the files of the shipped samples into the wheel, from `configs/` and `sample_models/`; all else: pyproject.toml.

An editable installation reads them where they are.
"""

import sys
from pathlib import Path

from setuptools import Command, setup
from setuptools.command.build import build

sys.path.insert(0, str(Path(__file__).parent))

from tedm_cli.samples.shipped import sources


class BuildSamples(Command):
    """A part of `build` (`setuptools.command.build.SubCommand`)."""

    build_lib: str | None
    editable_mode: bool

    def initialize_options(self) -> None:
        self.build_lib = None
        self.editable_mode = False

    def finalize_options(self) -> None:
        self.set_undefined_options("build_py", ("build_lib", "build_lib"))

    def run(self) -> None:
        if self.editable_mode:
            return
        for target, source in self.get_output_mapping().items():
            self.mkpath(str(Path(target).parent))
            self.copy_file(source, target)

    def get_output_mapping(self) -> dict[str, str]:
        return {str(Path(self.build_lib or "", "tedm_cli", "samples", name)): name for name in sources()}

    def get_outputs(self) -> list[str]:
        return list(self.get_output_mapping())

    def get_source_files(self) -> list[str]:
        return list(sources())


class Build(build):
    sub_commands = [*build.sub_commands, ("build_samples", None)]  # noqa: RUF012


setup(cmdclass={"build": Build, "build_samples": BuildSamples})
