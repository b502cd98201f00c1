"""Cache key of an object by its identity."""

from __future__ import annotations

from typing import Generic, TypeVar, final

Kept = TypeVar("Kept")


@final
class IdentityKey(Generic[Kept]):
    """Key of a design or a task by its identity, since hashing all its numbers takes as long as a solution."""

    __slots__ = ("value",)

    def __init__(self, value: Kept) -> None:
        self.value = value

    def __hash__(self) -> int:
        return id(self.value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, IdentityKey) and self.value is other.value
