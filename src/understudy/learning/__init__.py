"""The learner: from a lesson's examples to transition functions (docs/learning.md, paper section 3.2)."""

from understudy.kernel_cache import find_cache

find_cache()
