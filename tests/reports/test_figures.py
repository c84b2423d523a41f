"""Plots: however one is made, it looks alike."""

from autodb.reports import figures


def test_a_plot_alone_is_laid_out_like_one_of_several() -> None:
    title = "Feed [mm/rev]"
    alone = figures.lone_figure("Force [N]", x_title=title, y_axis={"zeroline": False})
    among = figures.figure(["Force [N]"], x_title=title)
    among.update_yaxes(zeroline=False)
    assert alone.layout == among.layout
