"""Hertz's contact of a half cylinder and a block beside Kratos and CalculiX; meshing is in nobody's time.

Every program runs in turns with the others, the peers with one thread and with all, and the fastest run counts. The
time is from meshes to displacements of all nodes and the contact pressure; CalculiX's is that of the whole program.
Accuracy is the relative error of the maximum pressure from Hertz's under the force that the program itself found.
Peers are given the approach that flangeway found for the load.
"""

import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from benchmarks.hertz_block import Block, Pressed, mesh_block, press_block
from benchmarks.hertz_block_peers import press_with_calculix, press_with_kratos
from benchmarks.measurement import NO_PEER, Measurement, fastest, fastest_in_turns, taken
from benchmarks.peers import PeerMissingError, threads_tried

COARSE, FINE = (0.1, 0.226), (0.05, 0.103)  # size at the contact and growth: 6,600 and 26,000 nodes
QUICK = (0.2, 0.3)
ROUNDS = 5
PEER_ROUNDS = 3

Job = Callable[[], Pressed]


def measurements() -> Iterator[Measurement]:
    """Both meshes, then ten load steps."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        coarse = mesh_block(*COARSE)
        yield from compare(coarse, folder, {"kratos": 5.0, "calculix": 10.0})
        yield from ten_steps(coarse, folder, with_peer=True)
        fine = mesh_block(*FINE)
        yield from compare(fine, folder, {"kratos": 15.0, "calculix": None})
        yield from ten_steps(fine, folder, with_peer=False)


def quick() -> Iterator[Measurement]:
    """A coarse mesh."""
    with tempfile.TemporaryDirectory() as name:
        block = mesh_block(*QUICK)
        yield from compare(block, Path(name), {"kratos": None, "calculix": None})
        yield from ten_steps(block, Path(name), with_peer=False)


def compare(block: Block, folder: Path, asked: dict[str, float | None]) -> Iterator[Measurement]:
    """One load step beside peers, with the ratios asked."""
    ours = press_block(block)
    peers = {"kratos": press_with_kratos, "calculix": press_with_calculix}
    jobs: dict[str, Job] = {"ours": partial(press_block, block)}
    rounds = {"ours": ROUNDS}
    for name in asked:
        for threads in threads_tried():
            jobs[f"{name} {threads}"] = partial(peers[name], block, ours.approach, folder, threads=threads)
            rounds[f"{name} {threads}"] = PEER_ROUNDS
    found = fastest_in_turns(jobs, rounds, _seconds)
    ours = taken(found["ours"])
    for name, ratio in asked.items():
        peer = fastest([found[job] for job in jobs if job.split()[0] == name], _seconds)
        work = f"Hertz's contact of a half cylinder and a block, {block.n_nodes} nodes"
        more = {"ours_half_width_accuracy": ours.half_width_error, "ours_force_accuracy": ours.force_error}
        if isinstance(peer, PeerMissingError):
            yield Measurement(work, name, ours.seconds, None, ours.peak_error, None, str(peer), asked=ratio, more=more)
            continue
        yield Measurement(
            work, name, ours.seconds, peer.seconds, ours.peak_error, peer.peak_error,
            f"ours of order 2; the peer found {peer.force:.2f} of 2000 N/mm at our approach of {ours.approach:.5f} mm",
            peer_version=peer.note, asked=ratio,
            more=more | {"peer_half_width_accuracy": peer.half_width_error},
        )  # fmt: skip


def ten_steps(block: Block, folder: Path, *, with_peer: bool) -> Iterator[Measurement]:
    """Ten load steps over one, of flangeway and of Kratos."""
    one = press_block(block)
    jobs: dict[str, Job] = {f"ours {n}": partial(press_block, block, n) for n in (1, 10)}
    rounds = dict.fromkeys(jobs, ROUNDS)
    if with_peer:
        for n in (1, 10):
            jobs[f"kratos {n}"] = partial(press_with_kratos, block, one.approach, folder, n_steps=n)
            rounds[f"kratos {n}"] = 1
    found = fastest_in_turns(jobs, rounds, _seconds)
    ours = taken(found["ours 10"])
    more = {"ours_ten_over_one": round(ours.seconds / taken(found["ours 1"]).seconds, 2), "asked_ten_over_one": 2.0}
    work = f"Hertz's contact of a half cylinder and a block, {block.n_nodes} nodes, ten load steps"
    peer = found.get("kratos 10")
    if peer is None:
        yield Measurement(work, NO_PEER, ours.seconds, None, ours.peak_error, None, "", more=more)
        return
    if isinstance(peer, PeerMissingError):
        yield Measurement(work, "kratos", ours.seconds, None, ours.peak_error, None, str(peer), more=more)
        return
    more["peer_ten_over_one"] = round(peer.seconds / taken(found["kratos 1"]).seconds, 2)
    yield Measurement(
        work, "kratos", ours.seconds, peer.seconds, ours.peak_error, peer.peak_error,
        "equal steps of the approach; ours finds the approach of the load in the last", peer.note, more=more,
    )  # fmt: skip


def _seconds(pressed: Pressed) -> float:
    return pressed.seconds
