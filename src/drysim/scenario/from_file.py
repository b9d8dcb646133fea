"""What a scenario knows of the file that it was read from, and of its own words."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from pydantic import PrivateAttr

from drysim.errors import Problem
from drysim.quantity import Block
from drysim.source import Document, Keys


class FromFile(Block):
    """Blocks that were read from a file and can tell where each of their words stands."""

    _document: Document | None = PrivateAttr(default=None)
    _words: dict[str, dict[str, Any]] = PrivateAttr(default_factory=dict)
    _kept: dict[Any, Block] = PrivateAttr(default_factory=dict)
    _named_law: str = PrivateAttr(default="")

    def model_post_init(self, context: Any, /) -> None:
        """Keep the document, which the context of the validation names."""
        if isinstance(context, Mapping):
            self._document = context.get("document")

    @property
    def folder(self) -> Path:
        """The folder that the paths of records are relative to."""
        return Path(self._document.file).parent if self._document else Path()

    @property
    def origin(self) -> dict[str, Any]:
        """Name of the file, its SHA-256 and the overrides, as plain values."""
        read = self._document
        if read is None:
            return {"file": "", "sha256": "", "overrides": {}}
        file = Path(read.file).name
        return {"file": file, "sha256": read.sha256, "overrides": dict(read.overrides)}

    def problem(self, sentence: str, key: str | Keys) -> Problem:
        """Give the located problem of a key, for faults that only a run can find."""
        keys = tuple(key.split(".")) if isinstance(key, str) else key
        name = ".".join(map(str, keys))
        if self._document is None:
            return Problem(sentence, key=name)
        return self._document.locate(keys).problem(sentence, name)

    def spoken(self, name: str) -> dict[str, Any]:
        """Give the words of a block as the file says them, overrides included."""
        return dict((self._document.value if self._document else {}).get(name) or {})

    def words_of(self, name: str) -> dict[str, Any]:
        """Give the words of a block as it is now; empty where there is none."""
        if name not in self._words:
            block = getattr(self, name, None)
            if not isinstance(block, Block):
                return {}
            self._words[name] = block.model_dump(by_alias=True, exclude_none=True)
        return self._words[name]

    @property
    def named_law(self) -> str:
        """The friction law that a comparison names in place of the file's; empty for none."""
        return self._named_law

    @property
    def kept(self) -> dict[Any, Block]:
        """Blocks that were made from these and will be wanted again."""
        return self._kept

    def copied(self, changed: Mapping[str, Any], law: str = "") -> Self:
        """Give a copy with other values in some fields, which must be valid ones.

        `law` is the friction law that a comparison names in place of the file's.
        """
        copy = self.model_copy(update=changed)
        copy._words, copy._kept = {}, {}
        copy._named_law = law or self._named_law
        return copy
