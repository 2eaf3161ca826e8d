"""Where the sun stands at a place and time, and how much of its light comes through a clear sky.

The position is by the formulas of NOAA's solar calculator, which are J. Meeus' of low accuracy ("Astronomical
Algorithms", 1991, chapter 25): within 0.02° from 1900 to 2100, without refraction, which lifts the setting sun by half
a degree. The light is by Preetham, Shirley and Smits, "A practical analytic model for daylight", 1999, appendix A.1:
air that scatters as molecules do, and haze; without ozone and water vapour.
"""

from datetime import UTC, datetime
from math import asin, atan2, cos, degrees, exp, radians, sin, tan

from gpu.scene.types import Rgb

_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)
_DAYS_A_CENTURY = 36525.0
_WAVELENGTHS = (0.61, 0.55, 0.465)  # of red, green and blue [µm]
_HAZE = 0.04608 * 2.5 - 0.04586  # Ångström's turbidity of a clear sky, whose turbidity is 2.5


def sun_position(latitude: float, longitude: float, time: datetime) -> tuple[float, float]:
    """The sun's azimuth, clockwise from north, and its height above the horizon [°], at a place [°, north and east are
    positive] and a time with its zone.
    """
    century = (time - _J2000).total_seconds() / 86400.0 / _DAYS_A_CENTURY
    mean_longitude = radians(280.46646 + century * (36000.76983 + 0.0003032 * century))
    anomaly = radians(357.52911 + century * (35999.05029 - 0.0001537 * century))
    eccentricity = 0.016708634 - century * (0.000042037 + 0.0000001267 * century)
    node = radians(125.04 - 1934.136 * century)
    centre = (
        sin(anomaly) * (1.914602 - century * (0.004817 + 0.000014 * century))
        + sin(2.0 * anomaly) * (0.019993 - 0.000101 * century)
        + sin(3.0 * anomaly) * 0.000289
    )
    apparent = mean_longitude + radians(centre - 0.00569 - 0.00478 * sin(node))
    seconds = 21.448 - century * (46.815 + century * (0.00059 - 0.001813 * century))
    obliquity = radians(23.0 + (26.0 + seconds / 60.0) / 60.0 + 0.00256 * cos(node))
    declination = asin(sin(obliquity) * sin(apparent))

    y = tan(obliquity / 2.0) ** 2
    equation = (  # of time [rad]
        y * sin(2.0 * mean_longitude)
        - 2.0 * eccentricity * sin(anomaly)
        + 4.0 * eccentricity * y * sin(anomaly) * cos(2.0 * mean_longitude)
        - 0.5 * y * y * sin(4.0 * mean_longitude)
        - 1.25 * eccentricity**2 * sin(2.0 * anomaly)
    )
    day = time.astimezone(UTC)
    hours = day.hour + day.minute / 60.0 + (day.second + 1e-6 * day.microsecond) / 3600.0
    hour_angle = radians(15.0 * hours - 180.0 + longitude) + equation

    north = radians(latitude)
    to_east = -cos(declination) * sin(hour_angle)
    to_north = cos(north) * sin(declination) - sin(north) * cos(declination) * cos(hour_angle)
    up = sin(north) * sin(declination) + cos(north) * cos(declination) * cos(hour_angle)
    return degrees(atan2(to_east, to_north)) % 360.0, degrees(asin(max(min(up, 1.0), -1.0)))


def sun_direction(azimuth: float, height: float, north: float) -> Rgb:
    """Where the light of the sun goes, in a world whose +Y is up; azimuth, height: as of `sun_position`.

    north: from −Z to the north, clockwise as seen from above [°].
    """
    bearing, level = radians(azimuth + north), cos(radians(height))
    return -level * sin(bearing), -sin(radians(height)), level * cos(bearing)


def sun_strength(height: float) -> Rgb:
    """The share of each channel that comes through the air, of what does when the sun is overhead; 0 below the horizon.

    height: above the horizon [°].
    """
    if height <= 0.0:
        return 0.0, 0.0, 0.0
    air = 1.0 / (sin(radians(height)) + 0.15 * (height + 3.885) ** -1.253)  # of that overhead
    red, green, blue = (exp((0.008735 * it**-4.08 + _HAZE * it**-1.3) * (1.0 - air)) for it in _WAVELENGTHS)
    return min(red, 1.0), min(green, 1.0), min(blue, 1.0)
