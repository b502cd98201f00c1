"""Figures of learning: every line is drawn over its abscissae, and what is asked for beside it."""

from spiraltrunk.report.learning_curve import Curve, build_learning_figure


def test_one_panel_for_each_curve() -> None:
    curves = [
        Curve(
            title="Loss", xlabel="Updates", ylabel="Loss [-]", x=[1, 2], lines={"a": [3, 1], "b": [4, 2]}, is_log=True
        ),
        Curve(title="Success", xlabel="Tries", ylabel="Rate [%]", x=[1, 2, 3], lines={"mean": [0, 50, 90]}, bar=80.0),
    ]
    loss, success = build_learning_figure(curves, "Learning").axes
    assert [line.get_ydata().tolist() for line in loss.lines] == [[3, 1], [4, 2]]
    assert (loss.get_yscale(), success.get_yscale()) == ("log", "linear")
    assert success.lines[1].get_ydata() == [80.0, 80.0]
    assert [text.get_text() for text in success.get_legend().get_texts()] == ["mean", "asked for"]
