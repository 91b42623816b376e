"""Pictures out of messages, in RGB: sensor_msgs/Image and CompressedImage, Foxglove's too."""

from __future__ import annotations

import base64
import binascii
import io
from typing import TYPE_CHECKING, Any

from lfr.importing.bag.decoding import MessageError, fields, get

if TYPE_CHECKING:
    from PIL.Image import Image

# How Pillow calls the bytes of a pixel, and how many there are, by the encoding of an image.
RAW = {
    "rgb8": ("RGB", "RGB", 3),
    "bgr8": ("RGB", "BGR", 3),
    "rgba8": ("RGB", "RGBX", 4),
    "bgra8": ("RGB", "BGRX", 4),
    "mono8": ("L", "L", 1),
    "8UC1": ("L", "L", 1),
}
DEPTH = ("16UC1", "mono16", "32FC1")
DEPTH_IS = "a picture of depth, which a video of 8 bits would spoil; leave it out"
FILES = ("JPEG", "PNG", "WEBP")
MODES = ("RGB", "L", "RGBA", "P")  # of a file, which lose nothing as 8 bits of each colour
TYPES = ("Image", "CompressedImage", "RawImage")


def is_picture(type: str) -> bool:
    """Whether messages of a type are pictures: `sensor_msgs/msg/Image`."""
    return type.replace(".", "/").rsplit("/", 1)[-1] in TYPES


def picture(message: Any) -> Image:
    """The picture of a message.

    Raises:
        MessageError: an encoding that is not supported, or bytes that are no such picture.
    """
    check_kind(message)
    return _raw(message) if "encoding" in fields(message) else _file(message)


def check_kind(message: Any) -> None:
    """Raises MessageError when a message is no picture, or one in an encoding not supported."""
    there = fields(message)
    if "data" not in there or not {"encoding", "format"} & set(there):
        raise MessageError(f"no picture; it has the fields {', '.join(there)}")
    if "encoding" not in there:
        if "compressedDepth" in (said := str(get(message, "format"))):
            raise MessageError(f"{said}: {DEPTH_IS}")
        return
    encoding = get(message, "encoding")
    if encoding in DEPTH:
        raise MessageError(f"{encoding}: {DEPTH_IS}")
    if encoding not in RAW:
        raise MessageError(f"pictures in {encoding or 'no encoding'}; supported: {', '.join(RAW)}")


def _raw(message: Any) -> Image:
    from PIL import Image

    encoding = get(message, "encoding")
    mode, raw, bytes_per_pixel = RAW[encoding]
    width, height, step = (int(get(message, name)) for name in ("width", "height", "step"))
    data = _bytes(message)
    if width < 1 or height < 1 or step < width * bytes_per_pixel or len(data) < step * height:
        raise MessageError(f"{len(data)} bytes for {width} x {height} pixels in {encoding}, "
                           f"{step} bytes a row")  # fmt: skip
    return Image.frombuffer(mode, (width, height), data, "raw", raw, step, 1).convert("RGB")


def _file(message: Any) -> Image:
    from PIL import Image

    said = str(get(message, "format"))
    try:
        image = Image.open(io.BytesIO(_bytes(message)), formats=FILES)
        if image.mode not in MODES:
            raise MessageError(f"a picture of mode {image.mode}; supported: {', '.join(MODES)}")
        return image.convert("RGB")
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        supported = "JPEG, PNG and WebP"
        raise MessageError(f"a picture in {said or 'no format'} that cannot be decoded; supported: "
                           f"{supported}: {error}") from None  # fmt: skip


def _bytes(message: Any) -> bytes:
    data = get(message, "data")
    if isinstance(data, str):  # in JSON
        try:
            return base64.b64decode(data, validate=True)
        except binascii.Error as error:
            raise MessageError(f"a picture that is no base64: {error}") from None
    if not isinstance(data, bytes):
        raise MessageError(f"a picture whose data is {type(data).__name__}, not bytes")
    return data
