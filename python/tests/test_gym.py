"""Environments of Gymnasium: its own checks, one against many, seeds, failures."""

from __future__ import annotations

import copy
import pickle
import warnings

import gymnasium
import mimbre
import mimbre.gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env


@pytest.fixture(scope="module")
def cart() -> mimbre.Model:
    """A pole on a cart, which starts as a parameter of its file says; `k` is a spring that can be tuned."""
    m = mimbre.ModelBuilder("Cart-pole")
    m.add_parameter("start", 0.1)
    m.add_parameter("k", 2.0, min=0, max=10, tunable=True)
    m.add_input("force", 0.0, range=[-10, 10], unit="N")
    m.add_input("free", 0.0)
    m.add_body("cart", mass=1, com=[0, 0, 0], inertia=[0.01, 0.01, 0.01], shapes=[{"box": [0.3, 0.2, 0.1]}])
    m.add_body("pole", mass=0.1, com=[0, 0, 0.5], inertia=[0.01, 0.01, 1e-5])
    m.add_joint("rail", type="prismatic", between=["ground", "cart"], at=[0, 0, 0], axis=[1, 0, 0])
    m.add_joint("pin", type="revolute", between=["cart", "pole"], at=[0, 0, 0], axis=[0, 1, 0], position="start")
    m.add_actuator("motor", joint="rail", force="force - k*place")
    m.add_output("place", joint="rail")
    m.add_output("angle", joint="pin")
    m.add_signal("reward", "-angle^2 - place^2")
    m.add_signal("fallen", "angle^2 > 0.25 ? 1 : 0")
    m.set_simulation(step=0.01)
    return m.compile()


def said(**more):
    return {
        "actions": ["force"],
        "observations": ["place", "angle"],
        "reward": "signal.reward",
        "terminate": "signal.fallen",
        "time_limit": 0.8,
        "skip": 2,
        "randomise": {"start": (-0.2, 0.2), "k": [1, 2.5]},
        **more,
    }


def test_gymnasium_s_check_passes(cart):
    env = mimbre.gym.make(cart, render_mode="rgb_array", **said())
    assert env.action_space == gymnasium.spaces.Box(-10, 10, (1,), np.float64)
    assert env.observation_space.shape == (2,)
    assert env.metadata["render_fps"] == 50
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        check_env(env)
    narrow = mimbre.gym.make(cart, **said(actions={"force": (-1, 2)}, observations={"place": (-5, 5)}))
    assert (narrow.action_space.low, narrow.action_space.high) == (-1, 2)
    assert (narrow.observation_space.low, narrow.observation_space.high) == (-5, 5)


def same(one, other) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray) and one.dtype == object:
        return all(same(a, b) for a, b in zip(one, other, strict=True))
    return bool(np.all(one == other))


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("randomise", [{"start": (-0.2, 0.2), "k": [1, 2.5]}, {"k": (1.0, 2.0)}, {}])
def test_many_are_as_so_many_ones(cart, mode, threads, randomise):
    """To the bit, with episodes that end in their time or before, and begin again."""
    keys = said(randomise=randomise)
    ones = gymnasium.vector.SyncVectorEnv([lambda: mimbre.gym.make(cart, **keys)] * 5, autoreset_mode=mode)
    many = mimbre.gym.make_vec(cart, 5, autoreset_mode=mode, threads=threads, **keys)
    assert many.action_space == ones.action_space
    assert many.observation_space == ones.observation_space
    random = np.random.default_rng(3)
    wanted, found = ones.reset(seed=7), many.reset(seed=7)
    ended = 0
    for _ in range(60):
        assert all(same(a, b) for a, b in zip(wanted, found, strict=True))
        actions = random.uniform(-12, 12, (5, 1))
        wanted, found = ones.step(actions), many.step(actions)
        ended += np.count_nonzero(found[2] | found[3])
    assert ended >= 5
    many.close()


def episode(env, seed, actions):
    seen = [env.reset(seed=seed)[0]]
    for action in actions:
        observation, reward, *_ = env.step(action)
        seen.append(np.append(observation, reward))
    return np.concatenate(seen)


def test_seeds_repeat(cart):
    actions = np.random.default_rng(0).uniform(-1, 1, (20, 1))
    env, other = (mimbre.gym.make(cart, **said()) for _ in range(2))
    first = episode(env, 1, actions)
    assert not np.array_equal(episode(env, 2, actions), first)
    assert np.array_equal(episode(env, 1, actions), first)
    assert np.array_equal(episode(other, 1, actions), first)


def test_a_copy_goes_on_by_itself(cart):
    env = mimbre.gym.make(cart, **said())
    env.reset(seed=1)
    env.step([3.0])
    others = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    wanted = env.step([-5.0])
    for other in others:
        assert all(same(a, b) for a, b in zip(wanted, other.step([-5.0]), strict=True))
        assert same(other.reset(seed=2)[0], env.reset(seed=2)[0])


def test_an_episode_is_the_simulation(cart):
    """The steps and the reward are those that can be had without Gymnasium; a function gives what a channel does."""
    env = mimbre.gym.make(
        cart, **said(randomise=None, reward=lambda now: -(now["angle"] ** 2) - now.observation[0] ** 2)
    )
    sim = cart.simulation()
    observation, info = env.reset(options={"k": 3})
    assert info == {"parameters": {"k": 3}}
    sim.input("k").value = 3
    for n in range(40):
        sim.input("force").value = 10
        sim.step(2)
        observation, reward, terminated, truncated, info = env.step(np.array([20.0]))  # beyond its range
        assert np.array_equal(observation, [sim.channel("place").value, sim.channel("angle").value])
        assert reward == pytest.approx(sim.channel("signal.reward").value, rel=1e-12)
        assert info == {}
        assert terminated == (abs(observation[1]) > 0.5)
        assert truncated == (n == 39)
        if terminated:
            break
    assert env.simulation.time == sim.time


def test_the_first_observation_is_of_the_values_of_the_episode(cart):
    """Of inputs, and of what is computed from them; after other episodes too."""
    m = mimbre.ModelBuilder()
    m.add_input("force", 0.0, range=[-1, 1])
    m.add_input("target", 1.0, range=[0, 5])
    m.add_body("cart", mass=1, com=[0, 0, 0], inertia=[1, 1, 1])
    m.add_joint("rail", type="prismatic", between=["ground", "cart"], at=[0, 0, 0], axis=[1, 0, 0], position=0.5)
    m.add_actuator("motor", joint="rail", force="force")
    m.add_output("place", joint="rail")
    m.add_signal("error", "target - place")
    m.set_simulation(step=0.01)
    keys = {
        "actions": ["force"],
        "observations": ["signal.error", "input.target", "input.force"],
        "reward": "signal.error",
        "randomise": {"target": (2.0, 5.0)},
    }
    env = mimbre.gym.make(m.compile(), **keys)
    for seed in range(3):
        observation, info = env.reset(seed=seed)
        target = info["parameters"]["target"]
        assert observation.tolist() == [target - 0.5, target, 0]
        env.step([1.0])
    assert env.reset(options={"target": 3})[0].tolist() == [2.5, 3, 0]
    envs = mimbre.gym.make_vec(m.compile(), 3, **keys)
    observations, infos = envs.reset(seed=1)
    assert np.array_equal(observations[:, 1], infos["parameters"]["target"])
    env = mimbre.gym.make(cart, **said(observations=["input.k", "angle"]))
    assert env.reset(options={"k": 3, "start": 0.05})[0].tolist() == [3, 0.05]


@pytest.mark.parametrize("formulation", ["relative", "natural"])
def test_an_episode_starts_at_the_equilibrium_of_its_inputs(formulation):
    """A mass on a spring: k z = F − m g."""
    m = mimbre.ModelBuilder(initial="equilibrium")
    m.add_parameter("mass", 2.0)
    m.add_parameter("k", 1000.0, min=100, max=5000, tunable=True)
    m.add_input("motor", 0.0, range=[-1, 1])
    m.add_input("weight", 0.0, range=[-100, 100])
    m.add_body("block", mass="mass", com=[0, 0, 0], inertia=[1, 1, 1])
    m.add_joint("rail", type="prismatic", between=["ground", "block"], at=[0, 0, 0], axis=[0, 0, 1])
    m.add_actuator("spring", joint="rail", force="motor + weight - k*z")
    m.add_output("z", joint="rail")
    m.set_simulation(step=0.01, formulation=formulation)
    env = mimbre.gym.make(
        m.compile(),
        actions=["motor"],
        observations=["z", "input.weight"],
        reward="z",
        randomise={"weight": (-50.0, 50.0), "k": (500.0, 2000.0)},
    )
    for given in ({}, {}, {"mass": 3.0}, {"weight": 20.0, "k": 700.0}, {}):
        observation, info = env.reset(options=given)
        drawn = {"mass": 2.0, **info["parameters"]}
        rest = (drawn["weight"] - drawn["mass"] * 9.81) / drawn["k"]
        assert observation == pytest.approx([rest, drawn["weight"]], rel=1e-6)
        assert env.step([0.0])[0][0] == pytest.approx(rest, rel=1e-6)  # and stays there


def test_an_episode_with_other_values_is_a_simulation_with_them():
    """One kilogram that `push` accelerates. At 3 N it is beyond the event from the start, which then never happens; so
    it is whatever episode went before, and an acceleration is seen at once."""
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        parameters: {mass: 1}
        inputs: {push: {start: 0, range: [-5, 5]}, action: {start: 0, range: [-1, 1]}, latch: 0}
        bodies: {b: {mass: mass, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0]}}
        actuators: {a: {joint: j, force: action + push + 10*latch}}
        events: {strong: {when: push, crosses: 1, direction: rising, set: {latch: 1}}}
        outputs: [{name: speed, joint_velocity: j}, {name: acceleration, joint_acceleration: j}]
        simulation: {step: 0.01, end: 1}
        """
    )
    keys = {"actions": ["action"], "observations": ["speed", "acceleration"], "reward": "speed"}
    env, envs = mimbre.gym.make(model, **keys), mimbre.gym.make_vec(model, 2, **keys)
    for options in ({"push": 3.0}, {"push": 3.0, "mass": 1.0}, {"push": 3.0}, {}, {"push": 3.0}):
        push = options.get("push", 0.0)
        assert env.reset(options=options)[0].tolist() == [0, push]
        assert envs.reset(options=options)[0].tolist() == [[0, push]] * 2
        for _ in range(10):
            observation = env.step([0.0])[0]
            observations = envs.step([[0.0], [0.0]])[0]
        sim = model.simulation(inputs={"push": push})
        sim.step(10)
        assert observation.tolist() == [sim.channel("speed").value, sim.channel("acceleration").value]
        assert observations.tolist() == [observation.tolist()] * 2
        assert observation == pytest.approx([0.1 * push, push])


def test_an_event_that_stops_the_run_terminates_the_episode():
    """At 0.5 m, reached by 2 m/s after 0.25 s: in the third action of ten steps, which ends there."""
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        inputs: {push: {start: 0, range: [-1, 1]}}
        bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], velocity: [2]}}
        actuators: {a: {joint: j, force: push}}
        events: {there: {when: place, crosses: 0.5, stop: true}}
        outputs: [{name: place, joint: j}]
        simulation: {step: 0.01}
        """
    )
    keys = {"actions": ["push"], "observations": ["place"], "reward": "place", "skip": 10, "time_limit": 2}
    env, envs = mimbre.gym.make(model, **keys), mimbre.gym.make_vec(model, 2, **keys)
    for episode in range(2):
        env.reset()
        for n in range(3):
            place, reward, terminated, truncated, info = env.step([0.0])
            assert (terminated, truncated, info) == (n == 2, False, {})
        assert place[0] == reward == pytest.approx(0.5)
        assert env.simulation.time == pytest.approx(0.25)
        if episode == 0:
            envs.reset()
        for n in range(3):
            places, _, terminations, truncations, _ = envs.step([[0.0], [0.0]])
            assert terminations.tolist() == [n == 2] * 2
            assert not truncations.any()
        assert places.tolist() == [[place[0]]] * 2
        assert envs.step([[0.0], [0.0]])[0].tolist() == [[0], [0]]  # begun again


def test_a_failed_step_ends_the_episode():
    m = mimbre.ModelBuilder()
    m.add_input("limit", 1.0, range=[0, 1])
    m.add_body("bar", mass=1, com=[0.5, 0, 0], inertia=[1e-3, 0.1, 0.1])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_actuator("motor", joint="hinge", torque="sqrt(limit - t)")
    m.add_output("angle", joint="hinge")
    m.set_simulation(step=0.01)
    keys = {"actions": ["limit"], "observations": ["angle"], "reward": "angle", "failure_reward": -7, "skip": 5}
    env = mimbre.gym.make(m.compile(), **keys)
    env.reset()
    assert env.step([1.0])[4] == {}
    observation, reward, terminated, truncated, info = env.step([0.0])
    assert np.isfinite(observation).all()
    assert (reward, terminated, truncated) == (-7, True, False)
    assert "t = 0.06 s" in info["failure"]
    envs = mimbre.gym.make_vec(m.compile(), 2, **keys)
    envs.reset()
    envs.step([[1.0], [1.0]])
    _, rewards, terminations, _, infos = envs.step([[1.0], [0.0]])
    assert terminations.tolist() == [False, True]
    assert rewards[1] == -7
    assert infos["failure"].tolist() == [None, info["failure"]]
    assert envs.step([[1.0], [1.0]])[0][1] == 0  # begun again


def test_functions_that_raise_are_heard(cart):
    def reward(now):
        raise RuntimeError("no such prize")

    env = mimbre.gym.make(cart, **said(reward=reward))
    env.reset()
    with pytest.raises(RuntimeError, match="no such prize"):
        env.step([0.0])
    env = mimbre.gym.make(cart, **said(reward=lambda now: float("nan")))
    env.reset()
    with pytest.raises(ValueError, match=r"reward: at t = 0.02 s its function gave nan; a finite number is needed"):
        env.step([0.0])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"actions": ["forc"]}, r"no input or tunable parameter 'forc' \(did you mean 'force'\?\)"),
        ({"actions": ["free"]}, r"'free' has no range.*\{'free': \(low, high\)\}"),
        ({"actions": "force"}, "a list of names"),
        ({"actions": ["force", "force"]}, "a name stands there twice"),
        ({"actions": {"force": (1, 1)}}, r"\(low, high\) is needed"),
        ({"actions": {"force": ("a", 1)}}, r"\(low, high\) is needed"),
        ({"actions": []}, "at least one"),
        ({"observations": ["angel"]}, "did you mean 'angle'"),
        ({"reward": "signal.rewards"}, "did you mean 'signal.reward'"),
        ({"reward": None}, "reward: a function or a channel's name"),
        ({"terminate": 3}, "terminate: a function or a channel's name"),
        ({"skip": 1.5}, "skip: is 1.5"),
        ({"skip": 0}, "skip: is 0"),
        ({"time_limit": 0.001}, "at least the 0.02 s of an action"),
        ({"randomise": {"force": (0, 1)}}, "'force' is an action"),
        ({"randomise": {"k": (0, 11)}}, "k: is .*; a number from 0 to 10"),
        ({"randomise": {"k": 3}}, r"k: \(low, high\), a list of values or a function"),
        ({"randomise": {"starts": (0, 1)}}, "starts"),
        ({"randomise": [1]}, "names with ranges"),
        ({"step": -1}, "step: is -1"),
        ({"view": "xx"}, "two of the axes"),
        ({"view": 3}, "two of the axes"),
        ({"render_mode": "human"}, "there is no render mode 'human'"),
    ],
)
def test_what_is_wrong_is_said(cart, wrong, message):
    with pytest.raises(mimbre.InputError, match=message):
        mimbre.gym.make(cart, **said(**wrong))


def test_misuse_is_told(cart):
    env, envs = mimbre.gym.make(cart, **said()), mimbre.gym.make_vec(cart, 2, **said())
    for one in (env, envs):
        with pytest.raises(gymnasium.error.ResetNeeded):
            one.step(one.action_space.sample())
    for options in ([1], {"kk": 1}, {"force": 1}, {"k": -1}):
        for one in (env, envs):
            with pytest.raises(mimbre.InputError):
                one.reset(options=options)
    with pytest.raises(mimbre.InputError, match="2 truth values are needed"):
        envs.reset(options={"reset_mask": [1, 2]})
    env.reset()
    envs.reset()
    for action in ([1.0, 2.0], [[1.0]], [np.nan], ["x"], None):
        with pytest.raises(mimbre.InputError, match="action"):
            env.step(action)
    with pytest.raises(mimbre.InputError, match=r"of shape \(2, 1\) is needed"):
        envs.step([[1.0]])
    with pytest.raises(mimbre.InputError, match="num_envs: is 0"):
        mimbre.gym.make_vec(cart, 0, **said())


def test_an_image(cart):
    env = mimbre.gym.make(cart, **said(render_mode="rgb_array", randomise=None))
    env.reset()
    image = env.render()
    assert image.shape == (360, 480, 3)
    assert image.dtype == np.uint8
    # The box of the cart and the line of the pole.
    lines = {name: np.array(ends) for name, ends in env.simulation.lines()}
    assert lines["cart"].shape == (24, 3)
    assert np.ptp(lines["cart"], axis=0) == pytest.approx([0.3, 0.2, 0.1])
    for _ in range(10):
        env.step([10.0])
    assert (env.render() != image).any()
    assert mimbre.gym.make(cart, **said()).render() is None
