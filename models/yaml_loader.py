"""A safe YAML loader that also understands OpenCV's matrices and floats without a dot."""

from __future__ import annotations

import re
from typing import Any

import yaml

# More values than any file that is read here has, counting what is repeated by an alias each time that it is.
_MOST_VALUES = 50_000


class CameraLoader(yaml.SafeLoader):
    """`yaml.SafeLoader` that reads `!!opencv-matrix` as a plain mapping, and `1e-05`, which ROS writes, as a float."""

    def __init__(self, stream: str) -> None:
        super().__init__(stream)
        self._values = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Compose a value, as long as there are not too many: this parser takes seconds for a hundred thousand."""
        self._values += 1
        if self._values > _MOST_VALUES:
            raise yaml.YAMLError(f"it holds more than {_MOST_VALUES} values")
        node: yaml.Node | None = super().compose_node(parent, index)
        return node

    def construct_opencv_matrix(self, node: yaml.MappingNode) -> dict[Any, Any]:
        """Return rows, cols, dt and data as they stand."""
        return self.construct_mapping(node, deep=True)


for _kind in ("opencv-matrix", "opencv-nd-matrix"):
    CameraLoader.add_constructor(f"tag:yaml.org,2002:{_kind}", CameraLoader.construct_opencv_matrix)
# YAML 1.1, which PyYAML follows, takes a number with an exponent but without a dot for text.
CameraLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?[0-9]+(?:\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)


def load_documents(text: str) -> list[Any]:
    """Return the documents of a YAML text, without the empty ones.

    Raises:
        yaml.YAMLError: no valid YAML, or one whose aliases unfold to more than any file here holds.

    """
    loader = CameraLoader(text)
    documents = []
    try:
        while loader.check_node():
            node = loader.get_node()
            if node is None:
                continue
            if _unfolded(node, {}) > _MOST_VALUES:
                raise yaml.YAMLError(f"its aliases unfold to more than {_MOST_VALUES} values")
            document = loader.construct_document(node)
            if document is not None:
                documents.append(document)
    finally:
        loader.dispose()
    return documents


def _unfolded(node: yaml.Node, known: dict[int, int]) -> int:
    """Number of values of a node with all its aliases written out."""
    if id(node) in known:
        return known[id(node)]
    known[id(node)] = _MOST_VALUES + 1  # what holds itself has no end
    children: list[yaml.Node] = []
    if isinstance(node, yaml.SequenceNode):
        children = node.value
    elif isinstance(node, yaml.MappingNode):
        children = [part for pair in node.value for part in pair]
    known[id(node)] = 1 + sum(_unfolded(child, known) for child in children)
    return known[id(node)]
