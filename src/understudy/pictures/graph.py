def automaton_svg() -> str:
    return ""
