"""The learner: from a lesson's examples to transition functions (docs/learning.md, paper section 3.2)."""
