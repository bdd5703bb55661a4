"""Every kernel of every registered class means the same on floats, arrays, JAX and in C."""

import builders
import kernels
import numpy as np
import pytest
from kernels import KERNELS, RUNTIMES, case_id, cases, disagreement, on_kernel_itself

from martensite.laws.liang_rogers import LiangRogers

TOLERANCE = 1e-12


@pytest.fixture(params=list(RUNTIMES))
def runtime(request):
    if request.param == "c":
        request.getfixturevalue("c_compiler")
    return RUNTIMES[request.param]


@pytest.mark.parametrize(("kind", "thing", "name"), cases(), ids=case_id)
def test_runtimes_agree(kind, thing, name, runtime):
    kernel = KERNELS[kind][name]
    inputs = kernel.inputs()
    meant = on_kernel_itself(thing, kernel, inputs)
    assert np.isfinite(meant).all()
    assert disagreement(meant, runtime(thing, kernel, inputs)) <= TOLERANCE


@pytest.mark.parametrize("perturbed", ["C_A", "M_s", "eps_L"])
def test_a_perturbed_constant_is_noticed(perturbed, runtime):
    law, kernel = builders.example(LiangRogers), KERNELS["law"]["path"]
    inputs = kernel.inputs()
    other = law.with_values({perturbed: getattr(law, perturbed) * (1 + 1e-9)})
    meant = on_kernel_itself(law, kernel, inputs)
    assert disagreement(meant, runtime(other, kernel, inputs)) > TOLERANCE


def test_the_sampled_paths_do_transform():
    law, kernel = builders.example(LiangRogers), KERNELS["law"]["path"]
    meant = on_kernel_itself(law, kernel, kernel.inputs())
    start, first, second = meant[0], meant[2], meant[4]
    assert np.mean(np.abs(first - start) > 1e-3) > 0.3
    assert np.mean(np.abs(second - first) > 1e-3) > 0.3


def test_every_kind_has_kernels():
    assert set(kernels.KERNELS) == set(builders.REGISTRIES) - {"waveform"}
