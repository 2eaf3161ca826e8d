"""Numbers that decide a stage's quality: a small dataclass a stage, which its kernels take as one struct.

@wp.struct
@dataclass
class SmoothingParameters:
    '''What each means, with its unit.'''

    light_tolerance: float = 3.0

usual = parameters(SmoothingParameters)
other = parameters(SmoothingParameters, light_tolerance=2.0)
"""

from typing import Any


def parameters(struct: Any, **changes: float) -> Any:
    """An instance of `struct`, a Warp struct made of a dataclass, with its defaults but for `changes`.

    Raises TypeError for a name that it does not have.
    """
    values, instance = struct.cls(**changes), struct()
    for name in struct.vars:
        setattr(instance, name, getattr(values, name))
    return instance
