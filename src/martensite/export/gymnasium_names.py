"""Names of the environments that `gymnasium.make` finds.

They are registered when `martensite.export.gymnasium` is imported, or this package after Gymnasium, which has had no
entry points for that since its version 1.0. A name may say itself what to import, in whatever order all else was:
`martensite.export.gymnasium:martensite/Finger-v0`.
"""

from __future__ import annotations

NAMESPACE = "martensite"
NAMES = ("Finger", "Hand", "Platform", "Wire")
"""Tasks that come with the package; `martensite.export.packaged_tasks` says what they are."""
MODULE = "martensite.export.gymnasium"


def register_environments() -> None:
    """Register `martensite/Finger-v0`, its siblings, and `martensite/Bench-v0` for user benches in Gymnasium."""
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
