"""The learner: builds transition functions from a lesson's examples (docs/learning.md, paper section 3.2)."""
