"""Names of the environments for `gymnasium.make`.

They are registered when `martensite.export.gymnasium` is imported, or this package after Gymnasium. A name can also
name its module: `martensite.export.gymnasium:martensite/Finger-v0`.
"""

from __future__ import annotations

NAMESPACE = "martensite"
NAMES = ("Finger", "Hand", "Platform", "Wire")
"""Tasks of `martensite.export.packaged_tasks`."""
MODULE = "martensite.export.gymnasium"


def register_environments() -> None:
    """Register the packaged tasks, such as `martensite/Finger-v0`, and `martensite/Bench-v0` for user benches."""
    from gymnasium.envs.registration import register, registry

    packaged = {f"{name}-v0": {"bench": name.lower()} for name in NAMES}
    for name, given in {"Bench-v0": {}, **packaged}.items():
        if f"{NAMESPACE}/{name}" not in registry:
            register(
                f"{NAMESPACE}/{name}",
                entry_point=f"{MODULE}:SmaEnv",
                vector_entry_point=f"{MODULE}_vector:SmaVectorEnv",
                kwargs=given,
            )
