"""Text of a person within markdown."""

import string

from spiraltrunk.studio.page.markdown import escape_markdown


def test_no_character_of_markup_stays_alone():
    given = "<b>x</b> *a* [b](http://c) _d_ `e` #f & ~g~ |h| {i} k@l.m ![n](o) \\"
    shown = escape_markdown(given)
    plain = shown.replace("\\\\", "").split("\\")
    assert not set("<>*[]()_`#&~|{}:@!") & set("".join(each[1:] for each in plain[1:]) + plain[0])
    unescaped = "".join(shown[i] for i in range(len(shown)) if shown[i] != "\\" or (i and shown[i - 1] == "\\"))
    assert unescaped == given


def test_words_stay_and_lines_become_one():
    assert escape_markdown("too wide by 20 mm\n# head") == "too wide by 20 mm \\# head"
    assert set(escape_markdown(string.ascii_letters + string.digits)) == set(string.ascii_letters + string.digits)
