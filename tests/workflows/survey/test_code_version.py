"""Work for other machines, which refuses other code."""

from __future__ import annotations

import pytest

from spiraltrunk.errors import SurveyError
from spiraltrunk.workflows.survey.code_version import SameCode, compute_code


def test_the_same_code_does_the_work() -> None:
    assert SameCode(work=str.upper, code=compute_code())("kick") == "KICK"


@pytest.mark.parametrize(("key", "value"), [("source", "0" * 16), ("versions", {})])
def test_other_code_is_refused(key: str, value: object) -> None:
    with pytest.raises(SurveyError, match=rf"has another spiraltrunk or other packages \({key} differ\); allowed"):
        SameCode(work=str.upper, code=compute_code() | {key: value})("kick")
