"""Which of the walks whose frames are on a GPU at once have their stages timed."""

# So many speak for all, since events that time stages cost the host up to 0.4 ms a frame. One that has had no frame
# while there were so many has ended, or rests.
MOST_WALKS, RESTED_FRAMES = 4, 256


class TimedWalks:
    """Those of a process, by numbers of their views.

    They stay the same while they go on: frames that are timed have graphs of their own (gpu.core.stages).
    """

    def __init__(self) -> None:
        self._frames = 0
        self._last: dict[int, int] = {}  # which of the frames was the last of each walk

    def includes(self, number: int) -> bool:
        """Whether the frame that comes next, of the view of this number, is to be timed."""
        self._frames += 1
        if number not in self._last and len(self._last) == MOST_WALKS:
            oldest, frame = min(self._last.items(), key=lambda item: item[1])
            if self._frames - frame <= RESTED_FRAMES:
                return False
            del self._last[oldest]
        self._last[number] = self._frames
        return True


TIMED_WALKS = TimedWalks()
