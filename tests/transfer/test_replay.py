"""The ring buffer against a list."""

import torch

from lfr.transfer.replay import Batch, Replay


def _rows(first, count):
    """Transitions whose every entry tells which one it is."""
    i = torch.arange(first, first + count, dtype=torch.float32)
    wide = [i[:, None] + torch.arange(n) / 16 for n in (3, 2)]
    d, z = wide
    return Batch(d, z, i, i / 2, d + 0.5, z + 1, z + 2, z + 3, z + 4)


def test_holds_the_newest_and_keeps_rows_together():
    replay, generator = Replay(5, 3, 2), torch.Generator().manual_seed(0)
    first = 0
    for count in (2, 2, 3, 1):  # 8 in all, three of them written over
        replay.add(_rows(first, count))
        first += count
        assert len(replay) == min(first, 5)
        seen = set()
        batch = replay.sample(200, generator)
        for row in range(200):
            k = int(batch.reward[row])
            expected = _rows(k, 1)
            for column, want in zip(batch, expected, strict=True):
                assert torch.equal(column[row], want[0])
            seen.add(k)
        assert seen == set(range(max(0, first - 5), first))


def test_state_continues_the_ring():
    one, other = Replay(4, 3, 2), Replay(4, 3, 2)
    one.add(_rows(0, 3))
    other.load_state(one.state())
    for replay in (one, other):
        replay.add(_rows(3, 2))
    batches = [r.sample(50, torch.Generator().manual_seed(1)) for r in (one, other)]
    for a, b in zip(*batches, strict=True):
        assert torch.equal(a, b)
