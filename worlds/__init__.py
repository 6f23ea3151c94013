"""Raw simulators: numbers, state and reward. They know no language, no teacher and no agent."""
