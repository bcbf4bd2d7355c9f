"""What the overlay and the graph are made of: nodes of the trees, lines and pixels."""

from __future__ import annotations

import numpy as np
from harness import add, grid, part, render, run


def kept() -> object:
    (session,) = part("session")._sessions.values()
    return session


def check_nodes_are_those_of_the_last_update() -> None:
    ob = add("grid", grid("grid", 8), (0, 0, 1))
    render()
    nodes = kept().nodes_at(0)
    assert nodes.boxes.shape == (1, 2, 3)
    assert nodes.damage.shape == (1,)
    assert np.allclose(nodes.boxes[0, :, 2], 1.0, atol=1e-3)
    assert len(nodes.rebuilt) > 0
    assert kept().nodes_at(0) is nodes
    assert len(kept().nodes_at(3).boxes) > 1
    ob.location.z = 5
    render()
    assert np.allclose(kept().nodes_at(0).boxes[0, :, 2], 5.0, atol=1e-3)


def check_a_box_has_twelve_edges() -> None:
    box = np.array([[(0.0, 0.0, 0.0), (1.0, 2.0, 3.0)]])
    lengths = np.linalg.norm(np.diff(part("ui.overlay").edges(box), axis=2), axis=3)
    assert sorted(lengths.ravel().tolist()) == [1.0] * 4 + [2.0] * 4 + [3.0] * 4


def check_the_worst_nodes_are_drawn_last() -> None:
    overlay = part("ui.overlay")
    damage = np.array([0.2, 0.9, 0.0, 0.5])
    assert overlay.worst(damage, 3).tolist() == [0, 3, 1]
    colours = overlay.colours(np.array([0.0, 9.0, np.nan]))
    assert np.allclose(colours, [overlay.SOUND, overlay.DAMAGED, overlay.SOUND])


def check_a_graph_shows_lines_gaps_and_marks() -> None:
    graph = part("ui.graph")
    red = (1.0, 0.0, 0.0, 1.0)
    pixels = graph.draw([graph.Line([0.0, 1.0, float("nan"), 1.0], red)], [0, 0, 0, 1], 1.0)
    is_red = (pixels == red).all(axis=2)
    width = graph.SIZE[0]
    assert is_red[: graph.SIZE[1] // 2, : width // 6].any()
    assert is_red[graph.SIZE[1] // 2 :, width // 6 : width // 3].any()
    assert not is_red[:, width // 3 + 2 : width - 2].any()
    assert np.allclose(pixels[0, -1], graph.MARK)
    assert np.allclose(pixels[0, 0], graph.GROUND)


def check_a_new_graph_is_a_new_picture() -> None:
    graph = part("ui.graph")
    shown = graph.GraphIcon()
    pixels = graph.draw([], [], 1.0)
    shown.icon(1, pixels)
    (first,) = shown._previews.values()
    shown.icon(1, pixels)
    assert list(shown._previews.values()) == [first]
    shown.icon(2, np.ones_like(pixels))
    (second,) = shown._previews.values()
    assert min(second.image_pixels_float) == 1.0
    shown.close()
    shown.close()


run(globals())
