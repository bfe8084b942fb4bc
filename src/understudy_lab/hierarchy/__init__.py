"""The experiment on hierarchies and single automata: approaching and stopping, and foraging (section 4.2)."""
