"""The learner: builds transition functions from a lesson's examples (docs/learning.md, paper section 3.2)."""

from understudy.kernel_cache import choose_cache_folder

choose_cache_folder()
