"""Both seats learn at once: a student whom nobody has told what advice is, and a teacher who pays for what it says.

The student sees numbers: the state, and what is said to it. The teacher chooses what to say. Each is a softmax over a
linear function of what it sees, trained by policy gradients on its own rewards, all of it in this file:

    python examples/both_seats_learn.py --episodes 3000
"""

import argparse

import numpy as np
import pettingzoo

import llf_teacher  # noqa: F401 (registers the environments)
from pz_envs.seats import STUDENT, TEACHER

RATE, DECAY, BATCH = 0.03, 0.9, 10


class Learner:
    """REINFORCE with a baseline, and Adam's steps."""

    def __init__(self, inputs: int, actions: int, rng: np.random.Generator) -> None:
        self.weights, self.rng = np.zeros((inputs + 1, actions)), rng
        self.mean, self.square, self.updates, self.baseline = 0.0, 0.0, 0, 0.0
        self.steps, self.gradients, self.rewards = [], [], []

    def act(self, seen: np.ndarray, mask: np.ndarray) -> int:
        """An action by chance among those that the mask allows."""
        inputs = np.append(seen, 1.0)
        scores = np.where(mask, inputs @ self.weights, -np.inf)
        chances = np.exp(scores - scores.max())
        chances /= chances.sum()
        action = int(self.rng.choice(len(chances), p=chances))
        self.gradients.append(np.outer(inputs, np.eye(len(chances))[action] - chances))
        return action

    def end(self) -> None:
        """Weigh the episode's actions by what came of them."""
        total = 0.0
        for gradient, reward in zip(self.gradients[::-1], self.rewards[::-1], strict=True):
            total = reward + DECAY * total
            self.steps.append((gradient, total - self.baseline))
            self.baseline += 0.01 * (total - self.baseline)
        self.gradients, self.rewards = [], []

    def learn(self) -> None:
        """Make what turned out well more likely."""
        gradient = sum(part * gain for part, gain in self.steps) / len(self.steps)
        self.steps, self.updates = [], self.updates + 1
        self.mean += 0.1 * (gradient - self.mean)
        self.square += 0.001 * (gradient**2 - self.square)
        step = self.mean / (1 - 0.9**self.updates) / (np.sqrt(self.square / (1 - 0.999**self.updates)) + 1e-8)
        self.weights += RATE * step


def main() -> None:
    """Play and learn, and print how it goes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    env = pettingzoo.make("aec", "llf/gridworld-v0", speech="kinds", numbers=True, cost=0.001, until_success=True)
    rng = np.random.default_rng(arguments.seed)
    env.reset(seed=arguments.seed)
    student = Learner(len(env.observe(STUDENT)), int(env.action_space(STUDENT).n), rng)
    teacher = Learner(10, int(env.action_space(TEACHER).n), rng)
    found, said = [], []
    every = max(1, arguments.episodes // 10)
    print("| episodes | successful | said a turn |\n|---|---|---|")
    for episode in range(1, arguments.episodes + 1):
        env.reset()
        atoms, success = 0, False
        for agent in env.agent_iter():
            seen, reward, terminated, truncated, info = env.last()
            learner = teacher if agent == TEACHER else student
            success = info.get("success", success)  # which the student is told
            if learner.gradients:
                learner.rewards.append(reward)
            if terminated or truncated:
                env.step(None)
            elif agent == TEACHER:
                numbers = np.concatenate((seen["available"], seen["features"]))
                env.step(teacher.act(numbers, seen["action_mask"]))
            else:
                atoms += sum(atom.kind is not None for atom in env.unwrapped.session.atoms)
                env.step(student.act(seen, np.ones(4)))
        found.append(success)
        said.append(atoms / len(student.gradients))
        for learner in (student, teacher):
            learner.end()
            if episode % BATCH == 0:
                learner.learn()
        if episode % every == 0:
            print(f"| {episode} | {np.mean(found):.2f} | {np.mean(said):.2f} |", flush=True)
            found, said = [], []


if __name__ == "__main__":
    main()
