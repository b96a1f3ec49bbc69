"""Tables of the documentation, each between a pair of markers with its name."""


def between(text: str, name: str, content: str) -> str:
    """Return the page with `content` between two of its markers.

    The markers are `<!-- BEGIN:name -->` and `<!-- END:name -->`. Raises ValueError if the page
    lacks one of them.
    """
    begin, end = f"<!-- BEGIN:{name} -->", f"<!-- END:{name} -->"
    if begin not in text or end not in text:
        raise ValueError(f"the page has no markers '{name}'")
    head, _, rest = text.partition(begin)
    _, _, tail = rest.partition(end)
    return f"{head}{begin}\n\n{content}\n\n{end}{tail}"
