"""Random chains of lines and arcs, sampled evenly, unevenly or by their vertices, are read as they were drawn."""

import numpy as np
import pytest

from flangeway.railway.profiles.smoothing import smoothed

N_CHAINS = 8


def chain_points(lengths, curvatures, at):
    """Points (n, 2) of tangent lines and arcs at lengths from the start: the independent value."""
    starts = np.cumsum(lengths) - lengths
    turned = np.cumsum(lengths * curvatures) - lengths * curvatures

    def pieces(along, number):
        bend = curvatures[number] * along
        return along * np.sinc(0.5 * bend / np.pi) * np.exp(1j * (turned[number] + 0.5 * bend))

    joints = np.cumsum(np.append(0.0, pieces(lengths, np.arange(len(lengths)))))
    number = np.clip(np.searchsorted(starts, at, side="right") - 1, 0, len(lengths) - 1)
    points = joints[number] + pieces(at - starts[number], number)
    return np.column_stack((points.real, points.imag)), np.abs(curvatures[number])


def lengths_of_points(kind, random, lengths):
    """Lengths at which a chain is sampled."""
    if kind == "vertices":  # ends of lines, and four intervals on each arc
        ends = np.cumsum(lengths)
        return np.unique(np.concatenate([np.linspace(b - a, b, 5) for a, b in zip(lengths, ends, strict=True)]))
    spacing = random.uniform(0.7, 5.0)
    steps = random.uniform(0.4, 1.0, 400) if kind == "uneven" else np.ones(400)
    at = np.append(0.0, np.cumsum(spacing * steps))
    return at[at < lengths.sum()]


@pytest.mark.parametrize("kind", ["even", "uneven", "vertices"])
def test_random_chains_are_read_within_half_a_sagitta(kind):
    """The curve through exact points is within half the local sagitta and 2 micrometres, without noise."""
    random = np.random.default_rng({"even": 1, "uneven": 2, "vertices": 3}[kind])
    for _ in range(N_CHAINS):
        n = random.integers(5, 9)
        # of alternating sides, so that no chain meets itself
        radii = np.exp(random.uniform(np.log(12.0), np.log(400.0), n)) * np.where(np.arange(n) % 2, 1.0, -1.0)
        curvatures = np.where(random.random(n) < 0.35, 0.0, 1.0 / radii)
        lengths = np.minimum(random.uniform(8.0, 30.0, n), 0.9 * np.abs(radii))
        at = lengths_of_points(kind, random, lengths)
        found = smoothed(chain_points(lengths, curvatures, at)[0])
        assert found.wavelength_mm == 0.0
        assert found.noise_um < 0.01
        dense = np.arange(0.0, at[-1], 0.2)
        points, curved = chain_points(lengths, curvatures, dense)
        interval = np.clip(np.searchsorted(at, dense, side="right") - 1, 0, len(at) - 2)
        own = np.zeros(len(at) - 1)
        np.maximum.at(own, interval, curved)
        beside = np.pad(own, 1)
        local = np.maximum.reduce([own, beside[:-2], beside[2:]])
        errors = 1e3 * found.curve.closest(points)[2]
        assert (errors < (62.5 * np.diff(at) ** 2 * local)[interval] + 2.0).all()
        assert (errors[local[interval] == 0.0] < 1.0).all()
