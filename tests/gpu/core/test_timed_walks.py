from gpu.core.timed_walks import MOST_WALKS, RESTED_FRAMES, TimedWalks


def test_few_walks_are_timed_and_another_once_one_of_them_rests() -> None:
    walks, crowd = TimedWalks(), range(MOST_WALKS + 2)
    for _ in range(RESTED_FRAMES):
        assert [walks.includes(number) for number in crowd] == [number < MOST_WALKS for number in crowd]
    others = crowd[1:]
    for _ in range(RESTED_FRAMES):
        timed = [number for number in others if walks.includes(number)]
    assert timed in ([*range(1, MOST_WALKS), number] for number in others[-2:])  # whichever of the two asked first
    assert not walks.includes(0)
