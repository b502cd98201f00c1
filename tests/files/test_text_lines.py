"""Lines read in blocks are those of the whole text, whatever ends them and wherever a block does."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import TakeError
from spiraltrunk.files import text_lines
from spiraltrunk.files.text_lines import Lines


@pytest.fixture(scope="module", params=[1, 2, 3, 7, 1 << 22])
def block(request: pytest.FixtureRequest) -> int:
    """Bytes that are read at once."""
    return int(request.param)


class Stream(io.BytesIO):
    """A stream that gives a few bytes at a time."""

    block = 1

    def read(self, size: int | None = -1) -> bytes:
        return super().read(self.block)


@given(st.lists(st.tuples(st.binary(max_size=5), st.sampled_from([b"\n", b"\r\n", b"\r"])), max_size=8), st.booleans())
def test_lines_are_those_of_the_whole_text(block: int, parts: list[tuple[bytes, bytes]], is_ended: bool) -> None:
    """As `bytes.splitlines` divides it; the last one may have no ending."""
    text = b"".join(line + end for line, end in parts) + (b"" if is_ended else b"last")
    text = b"#" + text.replace(b"\0", b"0")  # No mark and no zeros at the beginning, which tell of other encodings.
    stream = Stream(text)
    stream.block = block
    lines = Lines(stream, "it.csv")
    assert list(lines) == text.splitlines()
    assert lines.number == len(text.splitlines())
    assert lines.is_ended == text.endswith((b"\n", b"\r"))


def test_a_mark_of_utf_8_is_no_part_of_the_first_line() -> None:
    assert list(Lines(io.BytesIO(b"\xef\xbb\xbfa,b\r\n1,2\r\n"), "it.csv")) == [b"a,b", b"1,2"]


@pytest.mark.parametrize("text", ["a,b".encode("utf-16"), "a,b".encode("utf-32"), b"a\0b\0"])
def test_another_encoding_is_refused(text: bytes) -> None:
    with pytest.raises(TakeError, match=r"UTF-16 or binary; allowed: CSV in UTF-8"):
        list(Lines(io.BytesIO(text), "it.csv"))


def test_a_line_without_end_is_refused_with_its_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_lines, "_LONGEST", 10)
    with pytest.raises(TakeError, match="more than 10 bytes") as caught:
        list(Lines(io.BytesIO(b"a\nb\n" + 11 * b"c"), "it.csv"))
    assert caught.value.line == 3
