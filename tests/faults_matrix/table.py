# SPDX-License-Identifier: Apache-2.0
"""Markdown of a study's cells, and the totals."""
import judge

HEAD = ["cell", "horizontal, m", "attitude, deg", "wrong", "verdict", "reasons", "noticed after, s"]


def number(value):
    if value is None:
        return "–"
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def reasons_text(reasons):
    """"B104 fix.velocity, B106 fix": each once."""
    texts = []
    for reason in reasons:
        where = ".".join(part for part in (reason.get("measurement"), reason.get("part")) if part)
        text = f"{reason['code']} {where}".strip()
        if text not in texts:
            texts.append(text)
    return ", ".join(texts) or "–"


def noticed_text(cell):
    if cell.noticed is not None:
        return f"{cell.noticed:.1f}"
    return "no instant" if cell.reasons else "–"


def row(cell):
    cells = [cell.name, *(number(figure) for figure in cell.run.figures), "**wrong**" if cell.wrong else "no",
             f"**{cell.state}**" if cell.is_silent else cell.state, reasons_text(cell.reasons), noticed_text(cell)]
    if cell.kind == judge.WHILE:
        cells.append("never" if cell.recovered is None else f"{cell.recovered:.1f}")
    return cells


def markdown(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return lines + ["| " + " | ".join(cells) + " |" for cells in rows]


def in_words(cells):
    return ", ".join(f"{cell.name} ({cell.state})" for cell in cells) or "none"


def clean_text(clean):
    horizontal, attitude = clean.figures
    limits = judge.limits(clean)
    return (f"Without a fault: {number(horizontal)} m horizontally, {number(attitude)} deg of attitude, verdict `{clean.state}`"
            + (f" ({reasons_text(clean.reasons)})" if clean.reasons else "")
            + f". So a cell is wrong beyond {number(limits[0])} m or {number(limits[1])} deg.")


def totals(cells, unseeable):
    """Sentences, one each."""
    silent = [cell for cell in cells if cell.is_silent]
    named = [cell for cell in silent if cell.name in unseeable]
    yield (f"{len(cells)} cell{'s' * (len(cells) != 1)}; {sum(cell.wrong for cell in cells)} wrong, {len(silent)} of them with the verdict `ok`: "
           f"{', '.join(cell.name for cell in silent) or 'none'}; {len(named)} of these named as unseeable.")
    along = [cell for cell in cells if cell.kind == judge.ALONG]
    if along:
        unreported = [f"{cell.name} ({'wrong' if cell.wrong else 'not wrong'})" for cell in along if cell.state == "ok"]
        yield f"Wrong all along: {len(along) - len(unreported)} of {len(along)} reported; not reported: {', '.join(unreported) or 'none'}."
    a_while = [cell for cell in cells if cell.kind == judge.WHILE]
    if a_while:
        back, _ = judge.back(cells)
        others = [cell for cell in a_while if not cell.is_back]
        yield (f"Wrong for a while: {back} of {len(a_while)} ({100 * back / len(a_while):.0f} %, at least {100 * judge.BACK_SHARE:.0f} % are asked for) "
               f"back within {judge.BACK_WITHIN} s; the others: {in_words(others)}.")


def page(clean, cells, unseeable):
    """All of a study, as lines."""
    lines = [clean_text(clean), ""]
    lines += [f"- {sentence}" for sentence in totals(cells, unseeable)]
    for kind, more in ((judge.ALONG, []), (judge.WHILE, ["recovered after, s"])):
        rows = [row(cell) for cell in cells if cell.kind == kind]
        if rows:
            lines += ["", f"Wrong {kind}:", ""] + markdown(HEAD + more, rows)
    return lines


def replaced(text, name, lines):
    """The page with these lines between the markers of a study."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    if text.count(begin) != 1 or text.count(end) != 1 or text.index(begin) > text.index(end):
        raise judge.Bad(f"the page has no '{begin}' before '{end}'")
    head, rest = text.split(begin)
    return head + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end)[1]
