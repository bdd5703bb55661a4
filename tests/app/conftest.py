"""One bench for all tests of its interface."""

from collections.abc import Iterator

import pytest
from app_server import Bench, running
from page_runs import PageRuns


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with running(tmp_path_factory.mktemp("bench")) as made:
        yield made


@pytest.fixture(scope="session")
def page_runs(tmp_path_factory: pytest.TempPathFactory) -> PageRuns:
    return PageRuns(tmp_path_factory.mktemp("page"))
