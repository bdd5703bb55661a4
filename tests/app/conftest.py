"""One bench for all tests of its interface."""

from collections.abc import Iterator

import pytest
from app_server import Bench, running


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with running(tmp_path_factory.mktemp("bench")) as made:
        yield made
