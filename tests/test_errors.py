"""Messages name all that is given, and survive the way from another process."""

import pickle

import pytest

from lfr.errors import DataError, LfrError, MissingLibraryError, UnknownNameError


def test_unknown_name_lists_the_valid_ones() -> None:
    error = UnknownNameError("robot", "pando", ["panda", "sawyer"])
    assert str(error) == "unknown robot 'pando'; valid: panda, sawyer"


def test_data_error_names_all_that_is_known() -> None:
    error = DataError(
        "wrong type", file="a.parquet", episode=0, column="action", found="int", expected="float32"
    )
    expected = "wrong type: a.parquet, episode 0, column action, found int, expected float32"
    assert str(error) == expected
    assert str(DataError("cut off", file="a.mcap")) == "cut off: a.mcap"


@pytest.mark.parametrize(
    "error",
    [
        UnknownNameError("task", "x", ["lift"]),
        DataError("cut off", file="a", found=3),
        MissingLibraryError("install libegl1"),
    ],
)
def test_errors_come_back_from_another_process(error: LfrError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert again.__dict__ == error.__dict__
    assert again.exit_code == 2
