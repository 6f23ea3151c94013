"""Images for chat models: PNG in a data URL, of bounded size."""

import base64
import hashlib
import io
from collections.abc import Iterator, Mapping
from typing import Any

PIXELS = 512
"""Maximum side of an image that is sent; larger images are scaled down."""
_HEAD = "data:image/png;base64,"


def data_url(pixels: Any) -> str:
    """An image, uint8 (height, width, 3), as a data URL.

    Raises:
        ValueError: the array has another type or shape.
    """
    from PIL import Image

    if getattr(pixels, "dtype", None) != "uint8" or pixels.ndim != 3 or pixels.shape[2] != 3:
        shown = f"{type(pixels).__name__} {getattr(pixels, 'dtype', '')} {getattr(pixels, 'shape', '')}"
        raise ValueError(f"an image must be an array of uint8 (height, width, 3), got {shown}")
    image = Image.fromarray(pixels)
    image.thumbnail((PIXELS, PIXELS))
    file = io.BytesIO()
    image.save(file, "PNG", optimize=True)
    return _HEAD + base64.b64encode(file.getvalue()).decode()


def images_of(request: Mapping[str, Any]) -> Iterator[str]:
    """The data URLs of the images in a request's messages."""
    for message in request.get("messages", ()):
        content = message.get("content")
        for part in content if isinstance(content, list) else ():
            if part.get("type") == "image_url":
                yield part["image_url"]["url"]


def without_images(text: str, request: Mapping[str, Any]) -> str:
    """The text of a request, with each image replaced by its SHA-256."""
    for url in dict.fromkeys(images_of(request)):
        text = text.replace(url, f"sha256:{hashlib.sha256(url.encode()).hexdigest()}")
    return text
