"""A safe YAML loader that also understands OpenCV's matrices and floats without a dot."""

from __future__ import annotations

import re
from typing import Any

import yaml


class CameraLoader(yaml.SafeLoader):
    """`yaml.SafeLoader` that reads `!!opencv-matrix` as a plain mapping, and `1e-05`, which ROS writes, as a float."""

    def construct_opencv_matrix(self, node: yaml.MappingNode) -> dict[Any, Any]:
        """Return rows, cols, dt and data as they stand."""
        return self.construct_mapping(node, deep=True)


CameraLoader.add_constructor("tag:yaml.org,2002:opencv-matrix", CameraLoader.construct_opencv_matrix)
# YAML 1.1, which PyYAML follows, takes a number with an exponent but without a dot for text.
CameraLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?[0-9]+(?:\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)
