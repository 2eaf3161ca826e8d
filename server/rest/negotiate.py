"""Which image format a client gets, by its Accept header (RFC 9110, section 12.5.1)."""

from server.refusals import NotAcceptableError
from server.wire.worker import Output

MEDIA_TYPES: dict[str, Output] = {
    "image/png": ".png",
    "image/jpeg": ".jpg",
    "image/x-exr": ".exr",
    "application/x-npy": ".npy",
}


def choose_format(accept: str | None) -> tuple[str, Output]:
    """Media type and format that the client likes best, or PNG; NotAcceptableError when there is none."""
    ranges = dict(_parse(part) for part in (accept or "*/*").split(",") if part.strip())
    best, best_quality = "", 0.0
    for media_type in MEDIA_TYPES:
        # The most specific range that matches decides.
        wanted = (media_type, media_type.split("/")[0] + "/*", "*/*")
        quality = next((ranges[name] for name in wanted if name in ranges), 0.0)
        if quality > best_quality:
            best, best_quality = media_type, quality
    if not best:
        raise NotAcceptableError(
            f"Accept: {accept!r} has no format that can be written; choose of {', '.join(MEDIA_TYPES)}"
        )
    return best, MEDIA_TYPES[best]


def _parse(part: str) -> tuple[str, float]:
    name, *parameters = (word.strip().lower() for word in part.split(";"))
    for parameter in parameters:
        key, _, value = parameter.partition("=")
        if key == "q":
            try:
                return name, float(value)
            except ValueError:
                return name, 0.0
    return name, 1.0
