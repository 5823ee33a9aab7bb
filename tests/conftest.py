"""What tests of several kinds share."""

from collections.abc import Iterator

import pytest

from boom_mj.effects import effect_library, registry


@pytest.fixture(scope="session")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a Dask cluster of two processes on this machine."""
    distributed = pytest.importorskip("distributed")
    from dask import config

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "host": "127.0.0.1"}
    with (
        config.set({"distributed.scheduler.allowed-failures": 1}),  # every death costs the start of a process
        distributed.LocalCluster(**options, local_directory=str(tmp_path_factory.mktemp("dask"))) as made,
    ):
        yield made.scheduler_address


@pytest.fixture
def own_files() -> Iterator[None]:
    """Files of effects that a test loads are known in it alone."""
    known = dict(registry._files)
    yield
    registry._files.clear()
    registry._files.update(known)
    effect_library.cache_clear()
