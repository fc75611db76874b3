"""Words of the converter against the conversion of the fact sheet."""

from dataclasses import replace

import numpy as np
import pytest

from firmware_sim.description import SensorSpec
from firmware_sim.transducer import Transducers

SENSOR = SensorSpec(
    name="arm",
    frame="r_arm_ft_sensor",
    bus=2,
    address=13,
    full_scale=(1521.0, 1658.0, 1966.0, 34.0, 35.0, 22.0),
)
EXACT = replace(SENSOR, noise=(0.0, 0.0), offset=(0.0, 0.0))


def test_words_are_those_of_the_worked_examples() -> None:
    gauge = Transducers([EXACT], seed=1)
    (words,) = gauge.words(np.array([[0.0, -10.0, 50.0, 1.0, -0.5, 0.2]]))
    # can-protocol 12, examples 26 and 27, whose bytes are truncated where this converter rounds
    examples = [0x8000, 0x7F3A, 0x8341, 0x83C4, 0x7E2C, 0x812A]
    assert np.abs(np.subtract(words, examples)).max() <= 1
    assert words[0] == 0x8000
    assert words[3] == round(0x8000 / 34.0) + 0x8000


def test_words_stop_at_the_rails() -> None:
    gauge = Transducers([EXACT], seed=1)
    assert gauge.words(np.array([[1e5, -1e5, 0.0, 1e3, -1e3, 0.0]])) == [
        [0xFFFF, 0, 0x8000, 0xFFFF, 0, 0x8000]
    ]


def samples(sensor: SensorSpec, seed: int, index: int = 0) -> np.ndarray:
    gauge = Transducers([sensor] * (index + 1), seed)
    still = np.zeros((index + 1, 6))
    words = np.array([gauge.words(still)[index] for _ in range(2500)])
    values: np.ndarray = (words - 0x8000) * np.array(sensor.full_scale) / 0x8000
    return values


def test_noise_has_the_deviation_of_the_description() -> None:
    strong = replace(SENSOR, noise=(2.0, 0.05))
    assert samples(strong, seed=3).std(axis=0) == pytest.approx([2.0] * 3 + [0.05] * 3, rel=0.1)


def test_offset_is_constant_and_within_its_bound() -> None:
    mean = samples(replace(SENSOR, noise=(0.0, 0.0)), seed=3).mean(axis=0)
    offset = Transducers([SENSOR], seed=3).offset[0]
    quantum = np.array(SENSOR.full_scale) / 0x8000
    assert np.abs(mean - offset).max() <= quantum.max() / 2
    assert np.abs(offset[:3]).max() <= 2.0
    assert np.abs(offset[3:]).max() <= 0.1
    assert np.abs(offset).min() > 0.0


def test_seed_and_number_of_the_sensor_decide_its_draws() -> None:
    assert samples(SENSOR, 1).tolist() == samples(SENSOR, 1).tolist()
    assert samples(SENSOR, 1).tolist() != samples(SENSOR, 2).tolist()
    assert samples(SENSOR, 1, 0).tolist() != samples(SENSOR, 1, 1).tolist()


def test_noise_does_not_hang_on_the_bound_of_the_offset() -> None:
    wide = replace(SENSOR, offset=(20.0, 1.0))
    noise, same = samples(SENSOR, 1), samples(wide, 1)
    quantum = np.array(SENSOR.full_scale) / 0x8000
    drift = (noise - noise.mean(axis=0)) - (same - same.mean(axis=0))
    assert (np.abs(drift) <= 1.5 * quantum).all()
