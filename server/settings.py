"""How the service runs: defaults, then a TOML file, then LUMENWALK_* of the environment, then flags; the last one wins.

A nested field has two underscores in the environment: LUMENWALK_SCENE_LIMITS__MAX_TRIANGLES=1000000.
"""

import os
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, SecretStr, StringConstraints, ValidationError
from pydantic_settings import (
    BaseSettings,
    NoDecode,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
    TomlConfigSettingsSource,
)
from pydantic_settings.exceptions import SettingsError

from gpu.adaptive.levels import MOST
from gpu.errors import UserError
from gpu.sample_counts import paths_of, usual_counts
from gpu.scene.import_options import DEFAULT_OPTIONS, ImportOptions, listed
from gpu.scene.lighting.environment_options import EnvironmentOptions
from gpu.scene.limits import SceneLimits
from gpu.settings import Quality, RenderSettings
from server.addresses import check_host, check_network, check_origin, check_prefix, check_replica, replica_prefix
from server.wire.browser import MAX_SIDE, describe
from server.wire.log_format import LogFormat

BEST = usual_counts(Quality.BEST, cuda=True)
# Of render settings: a server has a limit of each, `max_` and its name.
COUNTS = ("samples", "vpls", "vpl_clusters", "sp_clusters", "photons", "gather_rays", "caustic_photons")
MIN_TOKEN_CHARACTERS = 16


def _check_token(token: SecretStr) -> SecretStr:
    text = token.get_secret_value()
    if len(text) < MIN_TOKEN_CHARACTERS or not (text.isascii() and text.isprintable()) or " " in text:
        raise ValueError(f"must be {MIN_TOKEN_CHARACTERS} or more printable ASCII characters without spaces")
    return token


Token = Annotated[SecretStr, AfterValidator(_check_token)]
Name = Annotated[str, StringConstraints(to_lower=True)]
Hosts = Annotated[tuple[Annotated[Name, AfterValidator(check_host)], ...], NoDecode, BeforeValidator(listed)]
Origins = Annotated[tuple[Annotated[Name, AfterValidator(check_origin)], ...], NoDecode, BeforeValidator(listed)]
Networks = Annotated[tuple[Annotated[Name, AfterValidator(check_network)], ...], NoDecode, BeforeValidator(listed)]
MAX_REPLICAS = 256


def _check_replicas(urls: tuple[str, ...]) -> tuple[str, ...]:
    if len({replica_prefix(url) for url in urls}) < len(urls):
        raise ValueError("each replica needs a path prefix of its own")
    return urls


Replicas = Annotated[
    tuple[Annotated[str, AfterValidator(check_replica)], ...],
    NoDecode,
    BeforeValidator(listed),
    AfterValidator(_check_replicas),
    Field(max_length=MAX_REPLICAS),
]

PREFIX = "LUMENWALK_"  # of names in the environment
_OF_KUBERNETES = re.compile(rf"{PREFIX}(\w+_)?(SERVICE_(HOST|PORT(_\w+)?)|PORT_\d+_\w+)")  # for a service of that name


class ServerSettings(BaseSettings, EnvironmentOptions):
    """Everything that whoever runs the service can choose."""

    model_config = SettingsConfigDict(
        env_prefix=PREFIX,
        env_nested_delimiter="__",
        env_ignore_empty=True,
        extra="forbid",
        frozen=True,
        nested_model_default_partial_update=True,
    )

    host: str = Field(default="127.0.0.1", min_length=1, description="address to listen on; loopback unless told")
    port: int = Field(default=8000, ge=0, le=65_535, description="TCP port; 0 takes a free one")
    token: Token | None = Field(
        default=None,
        description="secret that opens the service; off loopback one is made if none is given. Better in the "
        "environment than as a flag, which other users of the machine can see",
    )
    allowed_hosts: Hosts = Field(
        default=(), description="names, comma-separated, that the service is called by, as behind a proxy"
    )
    allowed_origins: Origins = Field(
        default=(), description="origins, comma-separated, of other pages that may use it, such as https://example.org"
    )
    root_path: Annotated[str, AfterValidator(check_prefix)] = Field(
        default="",
        description="path prefix below which a proxy shows the service, such as /walk; when not given, it is what "
        "trusted proxies say in X-Forwarded-Prefix",
    )
    trusted_proxies: Networks = Field(
        default=("127.0.0.1", "::1"),
        description="addresses or networks, comma-separated, of proxies whose X-Forwarded-For, -Proto, -Prefix count",
    )
    replicas: Replicas = Field(
        default=(),
        description="services, comma-separated, that POST /api/v1/assign chooses of, each as this one reaches it and "
        "with the path prefix that clients find it below, such as http://10.0.0.2:8000/r/0; they have this one's token",
    )
    keepalive_seconds: float = Field(
        default=20.0,
        ge=0.1,
        le=3600.0,
        description="of rest, after which a WebSocket is pinged and an event stream gets a comment: less than the "
        "shortest idle timeout of all proxies [s]",
    )
    log_format: LogFormat = Field(default=LogFormat.TEXT, description="one line of text, or of JSON, an event")
    scene: str = Field(default="cornell-box", min_length=1, description="served scene: a built-in name or a file")
    scenes_dir: Path | None = Field(default=None, description="folder whose scene files can be chosen too")
    device: str | None = Field(
        default=None,
        description='"cpu", "cuda:0", ...; several, comma-separated, a worker each, or "all"; the best there is when '
        "not given",
    )
    max_connections: int = Field(
        default=2048,
        ge=16,
        le=50_000,
        description="at the same time, half of them from one address; who asks for nothing makes room for others",
    )
    max_viewers: int = Field(default=32, ge=1, le=10_000, description="viewers at the same time")
    max_stream_pixels: int = Field(default=3840 * 2160, ge=1, le=MAX_SIDE**2, description="pixels of a streamed frame")
    max_pixels: int = Field(default=7680 * 4320, ge=1, le=MAX_SIDE**2, description="pixels of a still")
    max_samples: int = Field(default=4096, ge=1, le=65_536, description="samples a pixel")
    max_vpls: int = Field(default=1_048_576, ge=1, le=4_194_304, description="virtual point lights")
    max_vpl_clusters: int = Field(
        default=MOST.vpl_clusters, ge=1, le=65_536, description="clusters of virtual point lights"
    )
    max_sp_clusters: int = Field(default=MOST.sp_clusters, ge=1, le=262_144, description="clusters of shading points")
    max_photons: int = Field(default=1_048_576, ge=1, le=4_194_304, description="photons of photon-gather")
    max_gather_rays: int = Field(default=1024, ge=1, le=4096, description="rays of photon-gather at an SP cluster")
    max_caustic_photons: int = Field(default=1_048_576, ge=1, le=4_194_304, description="light paths of caustics")
    max_message_bytes: int = Field(default=65_536, ge=4096, le=2**24, description="one message or request body [bytes]")
    max_waiting_renders: int = Field(
        default=8,
        ge=1,
        le=1000,
        description="stills of one client that may wait, twice as many of all; more are told to retry",
    )
    max_wait_seconds: float = Field(
        default=60.0, gt=0.0, le=3600.0, description="that a still, a pick or an export waits for its turn [s]"
    )
    max_render_seconds: float = Field(
        default=3600.0, gt=0.0, description="that a still or job may be expected to take the device for [s]"
    )
    hang_seconds: float = Field(
        default=120.0,
        gt=0.0,
        le=3600.0,
        description="that the renderer may say nothing in a render before it is replaced",
    )
    max_scenes: int = Field(default=4, ge=1, le=1000, description="scenes kept on the device at the same time")
    reserve_bytes: int = Field(
        default=512 * 2**20, ge=0, description="of the device's memory, that loading a scene leaves free [bytes]"
    )
    edits: bool = Field(
        default=True, description="clients may change lights, materials and objects of scenes, for all who look"
    )
    max_own_edits: int = Field(
        default=8, ge=0, le=1000, description="viewers at once that may change scenes for themselves alone"
    )
    exports: bool = Field(default=False, description="clients may download scenes, with their edits, as GLB files")
    uploads: bool = Field(default=True, description="clients may upload scenes")
    uploads_dir: Path | None = Field(
        default=None,
        description="folder that keeps uploads, edits and results of jobs; when not given, they go with the service",
    )
    max_uploads: int = Field(default=64, ge=1, le=10_000, description="uploads kept; the longest unused make room")
    max_upload_bytes: int = Field(default=512 * 2**20, ge=1024, description="of one uploaded file [bytes]")
    max_uploads_bytes: int = Field(default=8 * 2**30, ge=1024, description="of all uploads, unpacked [bytes]")
    check_seconds: float = Field(default=25.0, gt=0.0, le=3600.0, description="that reading a scene file may take [s]")
    check_memory_bytes: int = Field(
        default=8 * 2**30, ge=512 * 2**20, description="that reading a scene file may take [bytes]"
    )
    max_jobs: int = Field(
        default=16, ge=1, le=1000, description="render jobs of one client that wait or run, twice as many of all"
    )
    job_result_seconds: float = Field(default=3600.0, ge=0.0, description="that the result of a job is kept [s]")
    job_results_bytes: int = Field(default=512 * 2**20, ge=0, description="of all results of jobs together [bytes]")
    jpeg_quality: int = Field(default=80, ge=1, le=100, description="of streamed frames while the camera moves")
    still_quality: int = Field(default=92, ge=1, le=100, description="of streamed frames of a still view")
    scene_options: ImportOptions = Field(default=DEFAULT_OPTIONS, description="how the served scene's file is read")
    scene_limits: SceneLimits = Field(default=SceneLimits(), description="how large a scene may be")

    @classmethod
    def settings_customise_sources(
        cls,
        settings_cls: type[BaseSettings],
        init_settings: PydanticBaseSettingsSource,
        env_settings: PydanticBaseSettingsSource,
        dotenv_settings: PydanticBaseSettingsSource,
        file_secret_settings: PydanticBaseSettingsSource,
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """Flags, then the environment, then the TOML file that `load_settings` was given."""
        return init_settings, env_settings, TomlConfigSettingsSource(settings_cls)

    @property
    def surroundings(self) -> EnvironmentOptions:
        """What is around every scene."""
        return EnvironmentOptions(**self.model_dump(include=set(EnvironmentOptions.model_fields)))

    def check_render(self, size: tuple[int, int], settings: RenderSettings, max_pixels: int) -> None:
        """UserError when a render asks for more than this service gives."""
        width, height = size
        if width * height > max_pixels:
            raise UserError(
                f"size: {width}×{height} is {width * height} pixels; this server renders up to {max_pixels}"
            )
        for name in COUNTS:
            wanted, limit = getattr(settings, name), getattr(self, f"max_{name}")
            if wanted is not None and wanted > limit:
                raise UserError(f"settings.{name}: {wanted} is more than this server's limit of {limit}")
            if wanted is None and (most := _most_left_open(settings, name)) > limit:
                raise UserError(
                    f"settings.quality: {settings.quality} takes up to {most} {name}, more than this server's limit of "
                    f"{limit}"
                )
            if settings.has_target and getattr(MOST, name, 0) > limit:
                raise UserError(
                    f"settings: a target may take up to {getattr(MOST, name)} {name}, more than this server's limit of "
                    f"{limit}; ask for counts instead"
                )


def _most_left_open(settings: RenderSettings, name: str) -> int:
    """How many of a count that is left open there may be; of what every service has to give, none."""
    if name == "samples" and settings.method.refines_by_samples:
        return paths_of(settings.quality)
    return int(getattr(BEST, name)) if settings.quality is Quality.BEST else 0


def load_settings(file: Path | None = None, flags: Mapping[str, Any] | None = None) -> ServerSettings:
    """The settings from `file`, the environment and `flags` (whose None means "not given").

    Raises UserError with the field and what is wrong with it, and with the file if it is that.
    """
    given = {name: value for name, value in (flags or {}).items() if value is not None}
    if file is not None and not file.is_file():
        raise UserError(f"{file}: there is no such settings file")

    class FromFile(ServerSettings):
        model_config = SettingsConfigDict(toml_file=file)

    try:
        return FromFile(**given)
    except ValidationError as error:
        field = str(next(iter(error.errors()[0]["loc"]), ""))
        raise UserError(f"{_source(field, file, given)}: {describe(error)}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UserError(f"{file}: not a TOML file: {error}") from None
    except SettingsError as error:
        raise UserError(f"settings: {error}") from None


def unknown_names(names: Iterable[str]) -> list[str]:
    """Of names in the environment those that look like settings and are none."""
    known = {f"{PREFIX}{field}".upper() for field in ServerSettings.model_fields}
    ours = (name for name in names if name.upper().startswith(PREFIX) and not _OF_KUBERNETES.fullmatch(name))
    return sorted(name for name in ours if name.upper().partition("__")[0] not in known)


def _source(field: str, file: Path | None, given: Mapping[str, Any]) -> str:
    """Where a wrong field is to be mended: in the file, if that has it and neither a flag nor the environment does."""
    told = (name.upper().partition("__")[0] for name in os.environ)  # of a nested field a part, or all of it
    elsewhere = field in given or f"{PREFIX}{field}".upper() in told
    return str(file) if file and not elsewhere and field in tomllib.loads(file.read_text()) else "settings"
