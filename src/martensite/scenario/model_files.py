"""JSON files of models of blocks; numbers are read back exactly.

A file holds the blocks with structure and fixed numbers, their free numbers by name, sample time, names, units and
ranges of the signals, the initial states of the fitted records, and the provenance of the model. Reading runs no code,
and only registered blocks are accepted.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from martensite.base.errors import DataError, InputError, MartensiteError
from martensite.base.files import read_text_file, write_file
from martensite.identify.blocks.base import BLOCKS, AbstractBlock
from martensite.identify.chains.chain import Chain, RecordStart
from martensite.identify.chains.scores import compute_rms, fit_percent
from martensite.signals.sampling.sampled import Sampled

if TYPE_CHECKING:
    from martensite.identify.chains.estimate import ChainEstimate

FORMAT = "martensite-model"
VERSION = 1
KEYS = ("format", "version", "name", "interval", "inputs", "outputs", "units", "taps", "blocks")
"""Required keys of a model file."""
NUMBERS = {"inf": math.inf, "-inf": -math.inf}
"""Numbers that JSON cannot write."""


def write_model(chain: Chain, path: str | Path, provenance: Mapping[str, Any] | None = None) -> None:
    """Write a chain as a JSON file; the file is replaced as a whole or not at all.

    Args:
        chain: the model.
        path: file ending in .json; its folder must exist.
        provenance: origin of the model, in plain values (see `model_provenance`).

    Raises:
        DataError: the path does not end in .json, or the file cannot be written.
        InputError: a value has no JSON form, or a free number is not finite.
    """
    path = Path(path)
    if path.suffix.lower() != ".json":
        raise DataError(f"A model file ends in .json, but this is `{path}`.")
    write_file(path, model_text(chain, provenance))


def model_text(chain: Chain, provenance: Mapping[str, Any] | None = None) -> str:
    """Return the text of a model file; arguments and errors as for `write_model`."""
    if not np.all(np.isfinite(chain.theta)):
        raise InputError(f"Model `{chain.name}` has free parameters that are not finite.")
    document = {
        "format": FORMAT,
        "version": VERSION,
        "name": chain.name,
        "structure": chain.text(),
        "interval": chain.interval,
        "inputs": list(chain.input_names),
        "outputs": list(chain.output_names),
        "units": dict(chain.units),
        "taps": None if chain.taps is None else [list(tap) for tap in chain.taps],
        "blocks": [
            block_table(block) | {"numbers": _name_numbers(block, theta)}
            for block, theta in zip(chain.blocks, chain.split(), strict=True)
        ],
        "ranges": {name: list(ends) for name, ends in chain.ranges.items()},
        "record_starts": {key: one._asdict() for key, one in chain.starts.items()},
        "provenance": dict(provenance or {}),
        "written_by": _describe_program(),
    }
    try:
        return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    except (TypeError, ValueError) as error:
        raise InputError(f"The provenance of a model must be plain values: {error}.") from None


def read_model(path: str | Path) -> Chain:
    """Return the chain of a file of `write_model`.

    Raises:
        DataError: the file does not exist, is damaged, or has an unknown block.
    """
    document = _read_document(Path(path))
    where = f"The model file `{path}`"
    try:
        return _read_chain(document)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise DataError(f"{where} is damaged: {type(error).__name__} at {error}.") from None
    except MartensiteError as error:
        raise DataError(f"{where} cannot be used: {error}") from None


def model_provenance(estimate: ChainEstimate) -> dict[str, Any]:
    """Return the provenance of an estimated model: records with hashes, fits and options."""
    return {
        "by": _describe_program(),
        "options": vars(estimate.options) | {"begin": [c.text() for c in estimate.options.begin]},
        "refined_fits": [float(fit) for fit in estimate.fits],
        "agreeing": int(estimate.agreeing),
        "iterations": int(estimate.solution.iterations),
        "converged": bool(estimate.solution.converged),
        "records": [_describe_record(estimate, record) for record in estimate.records],
    }


def _describe_record(estimate: ChainEstimate, record: Sampled) -> dict[str, Any]:
    computed = estimate.chain.simulate(record)  # from its fitted initial state
    fits = fit_percent(record.outputs, computed, estimate.options.skip)
    errors = compute_rms(record.outputs, computed, estimate.options.skip)
    return {
        "name": record.name,
        "samples": len(record),
        "sha256_of_numbers": record.hash,
        "fit_percent": dict(zip(record.output_names, map(float, fits), strict=True)),
        "rms": dict(zip(record.output_names, map(float, errors), strict=True)),
    }


# ---------------------------------------------------------------- writing


def _name_numbers(block: AbstractBlock, theta: Any) -> dict[str, float]:
    return dict(zip(block.numbers(), map(float, theta), strict=True))


def _describe_program() -> str:
    try:
        return f"martensite {version('martensite')}"
    except PackageNotFoundError:  # run from a source tree that was not installed
        return "martensite"


# ---------------------------------------------------------------- reading


def _read_document(path: Path) -> dict[str, Any]:
    text = read_text_file(path, "model")
    try:
        document = json.loads(text, parse_constant=_refuse_word)
    except (ValueError, RecursionError) as error:
        raise DataError(f"The model file `{path}` is not valid JSON: {error}.") from None
    if not isinstance(document, dict) or cast("Any", document).get("format") != FORMAT:
        raise DataError(f"The file `{path}` is no model file: it lacks `format: {FORMAT}`.")
    table = cast("dict[str, Any]", document)
    missing = [key for key in KEYS if key not in table]
    if missing:
        raise DataError(f"The model file `{path}` is damaged: it lacks {', '.join(missing)}.")
    if table["version"] != VERSION:
        raise DataError(
            f"The model file `{path}` is of version {table['version']}, but this program reads version {VERSION}."
        )
    return table


def _refuse_word(word: str) -> float:
    raise ValueError(f"{word} is no number of JSON")


def _read_chain(document: dict[str, Any]) -> Chain:
    blocks: list[AbstractBlock] = []
    theta: list[float] = []
    for number, table in enumerate(document["blocks"], start=1):
        block = block_of(table)
        given, names = dict(table["numbers"]), block.numbers()
        if set(given) != set(names):
            lost = ", ".join(sorted(set(names) ^ set(given)))
            raise DataError(f"the free parameters of block {number} do not fit its kind: {lost}.")
        blocks.append(block)
        theta += [_require_finite(given[name], f"`{name}` of block {number}") for name in names]
    interval = _require_finite(document["interval"], "`interval`")
    if not interval > 0.0:
        raise DataError(f"the sample time must be above 0 s, but is {interval:g} s.")
    taps = document["taps"]
    chain = Chain(
        tuple(blocks),
        np.array(theta),
        interval,
        tuple(map(str, document["inputs"])),
        tuple(map(str, document["outputs"])),
        {str(k): str(v) for k, v in dict(document["units"]).items()},
        None if taps is None else _read_taps(taps, blocks),
        str(document["name"]),
        {str(key): _read_start(one) for key, one in dict(document.get("record_starts", {})).items()},
        {str(key): (float(low), float(high)) for key, (low, high) in dict(document.get("ranges", {})).items()},
    )
    signals = {"inputs": (chain.input_names, chain.inputs), "outputs": (chain.output_names, len(chain.engine.taps))}
    for kind, (names, count) in signals.items():
        if len(names) != count:
            raise DataError(f"its blocks have {count} {kind}, but {len(names)} are named.")
    return chain


def _read_start(table: Mapping[str, Any]) -> RecordStart:
    state = tuple(_require_finite(value, "a state of `record_starts`") for value in table["state"])
    return RecordStart(str(table["name"]), str(table["kind"]), state)


def _read_taps(taps: Any, blocks: list[AbstractBlock]) -> tuple[tuple[int, int], ...]:
    pairs = tuple((int(block), int(output)) for block, output in taps)
    for block, output in pairs:
        if not (0 <= block < len(blocks) and 0 <= output < blocks[block].outputs):
            raise DataError(f"there is no output {output} of block {block}.")
    return pairs


def _require_finite(value: Any, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise DataError(f"{what} must be a finite number, but is {value!r}.")
    return float(value)


# ---------------------------------------------------------------- blocks as tables


def block_table(block: AbstractBlock) -> dict[str, Any]:
    """Return a block as a table of plain values; inner blocks are nested tables.

    Raises:
        InputError: the block is not registered, or has a value without a JSON form.
    """
    if not block.registered_name:
        raise InputError(
            f"Block `{type(block).__name__}` has no registered name and cannot be written; file "
            "its class with `@BLOCKS.register`."
        )
    values = {
        name: _require_plain(getattr(block, name), f"`{name}` of block `{block.registered_name}`")
        for name in block.declarations
    }
    return {"kind": block.registered_name, "parameters": values}


def block_of(table: dict[str, Any]) -> AbstractBlock:
    """Return the block of a table.

    Raises:
        InputError: the kind is not registered, or a value is out of range.
        KeyError, TypeError, ValueError: the table does not describe a block.
    """
    kind, given = str(table["kind"]), dict(table["parameters"])
    return BLOCKS[kind](**{name: _read_value(value) for name, value in given.items()})


def _require_plain(value: Any, what: str) -> Any:
    if isinstance(value, AbstractBlock):
        return block_table(value)
    if isinstance(value, (tuple, list)):
        return [_require_plain(one, what) for one in cast("list[Any]", value)]
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else {"number": str(float(value))}
    raise InputError(f"The value of {what} is a {type(value).__name__}, which no file can hold.")


def _read_value(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_read_value(one) for one in cast("list[Any]", value))
    if isinstance(value, dict):
        table = cast("dict[str, Any]", value)
        return NUMBERS[table["number"]] if "number" in table else block_of(table)
    return value
