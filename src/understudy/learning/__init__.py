"""The learner: from a lesson's examples to transition functions (docs/learning.md, paper section 3.2)."""

from understudy.kernel_cache import choose_cache_folder

choose_cache_folder()
