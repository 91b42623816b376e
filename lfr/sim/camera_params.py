"""Which cameras there are, and how large their pictures are."""

from collections.abc import Sequence
from dataclasses import dataclass

from lfr.errors import ParameterError, UnknownNameError

STOCK_NAMES = {
    "agentview": "agentview",
    "birdview": "birdview",
    "frontview": "frontview",
    "sideview": "sideview",
    "robotview": "robot0_robotview",
    "wrist": "robot0_eye_in_hand",
}
"""Name here -> robosuite's, of every arm; in `pick_place` robosuite has no sideview."""

LARGEST = 4096  # pixels of a side


@dataclass(frozen=True)
class CameraParams:
    """A camera and the size of its pictures.

    Raises:
        UnknownNameError: no camera of that name.
        ParameterError: a size that is not even, as video codecs want it, or too small or large.
    """

    name: str = "agentview"  # of STOCK_NAMES
    width: int = 128  # pixels
    height: int = 128

    def __post_init__(self) -> None:
        if self.name not in STOCK_NAMES:
            raise UnknownNameError("camera", self.name, STOCK_NAMES)
        for side in ("width", "height"):
            if (pixels := getattr(self, side)) not in range(2, LARGEST + 1, 2):
                raise ParameterError(
                    f"{side} of camera {self.name} must be an even number of pixels from 2 to "
                    f"{LARGEST}, found {pixels}"
                )


def check_names(cameras: Sequence[CameraParams]) -> None:
    """Raises ParameterError where two cameras have the same name, for pictures are called by it."""
    names = [camera.name for camera in cameras]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ParameterError(f"cameras: {', '.join(twice)} more than once; name each camera once")
