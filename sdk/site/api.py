#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A Markdown page for each public header, from Doxygen's XML: api.py XML PAGES

PAGES/binnacle/session.hpp.md and its like. Exit status 1, with a line each, where a public type has no doc line, a header
has no first line, or a header yields no page.
"""
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

NOT_PUBLIC = re.compile(r"(^|::)(detail|internal)(::|$)")
TYPES = {"class", "struct", "union", "enum", "typedef"}
DASHES = {"mdash": "—", "ndash": "–", "lsquo": "‘", "rsquo": "’", "ldquo": "“", "rdquo": "”"}


def escaped(text):
    return re.sub(r"([\\`*_<>\[\]#|])", r"\\\1", re.sub(r"\s+", " ", text or ""))


def squeezed(text):
    """C++ as one writes it: Doxygen puts blanks inside <>, and before & and *."""
    text = re.sub(r"\s+", " ", text or "").strip()
    text = re.sub(r"(?<=\w)< (?=\S)", "<", text)
    text = re.sub(r"(?<=\S) (?=>)(?!>=)", "", text)
    text = re.sub(r" ([&*]+)(?=[ )>,]|$)", r"\1", text)
    return re.sub(r" ([&*]+)(?=\w)", r"\1 ", text)


class Pages:
    def __init__(self, xml):
        self.items = {}    # header: [(line, item)]
        self.heads = {}    # header: description
        self.places = {}   # Doxygen's id of a type: (header, anchor)
        self.problems = []
        for path in sorted(xml.glob("*.xml")):
            for compound in ElementTree.parse(path).getroot().findall("compounddef"):
                self.add(compound)

    def add(self, compound):
        kind, name = compound.get("kind"), compound.findtext("compoundname")
        if kind == "file":
            self.heads[compound.find("location").get("file")] = compound
        if NOT_PUBLIC.search(name) or compound.get("prot", "public") == "private":
            return
        if kind in ("class", "struct", "union"):
            self.place(compound, name.split("binnacle::", 1)[-1])
        elif kind in ("file", "namespace"):
            for member in compound.iter("memberdef"):
                self.place(member, member.findtext("name"))

    def place(self, item, name):
        where = item.find("location")
        header = where.get("file")
        if item.get("id") in self.places:
            return
        self.places[item.get("id")] = (header, name)
        self.items.setdefault(header, []).append((int(where.get("line")), item))

    def text(self, element, header):
        """Markdown of what a description element holds."""
        if element is None:
            return ""
        text = escaped(element.text)
        for child in element:
            is_word = re.fullmatch(r"[A-Z][a-z]+", child.text or "") and re.search(r"(^|[.:;])\s*$", text)
            text += child.text if is_word and child.tag == "ref" else self.inline(child, header)
            text += escaped(child.tail)
        return re.sub(r"\n\n +", "\n\n", text)

    def inline(self, element, header):
        tag = element.tag
        if tag in DASHES:
            return DASHES[tag]
        if tag == "computeroutput":
            return "`" + squeezed("".join(element.itertext())) + "`"
        if tag == "ref":
            return self.link(element, header)
        if tag == "verbatim":
            return "\n\n```cpp\n" + element.text.rstrip() + "\n```\n\n"
        if tag == "para":
            return self.text(element, header).strip() + "\n\n"
        if tag in ("emphasis", "bold"):
            return "*" + self.text(element, header) + "*"
        if tag == "ulink":
            return f"[{self.text(element, header)}]({element.get('url')})"
        raise SystemExit(f"api.py: Doxygen's <{tag}> of {header} has no Markdown here")

    def link(self, element, header):
        text, place = "`" + "".join(element.itertext()) + "`", self.places.get(element.get("refid"))
        if place is None or element.get("kindref") != "compound":
            return text
        page = "" if place[0] == header else "../" * header.count("/") + place[0] + ".md"
        return f"[{text}]({page}#{anchor_of(place[1])})"

    def description(self, item, header):
        brief, detail = (self.text(item.find(tag), header).strip() for tag in ("briefdescription", "detaileddescription"))
        return (brief + ("\n\n" if detail.startswith("```") else " ") + detail).strip()

    def need_line(self, item, name):
        """A public type says what it is."""
        if item.get("kind") in TYPES and not "".join(item.find("briefdescription").itertext()).strip():
            where = item.find("location")
            self.problems.append(f"{where.get('file')}:{where.get('line')}: {name} has no doc line")


def anchor_of(name):
    return name.replace("::", "-")


def template_of(item):
    parameters = item.find("templateparamlist")
    if parameters is None:
        return ""
    texts = []
    for parameter in parameters.findall("param"):
        text = squeezed("".join(parameter.find("type").itertext())) + " " + (parameter.findtext("declname") or "")
        default = parameter.find("defval")
        texts.append(text.strip() + ("" if default is None else " = " + squeezed("".join(default.itertext()))))
    return "template <" + ", ".join(texts) + "> "


def signature(member):
    kind, name = member.get("kind"), member.findtext("name")
    type_text = squeezed("".join(member.find("type").itertext())) if member.find("type") is not None else ""
    arguments = re.sub(r"(?<=[\w ])=(?=[^=\s])", " = ", squeezed(member.findtext("argsstring"))).replace("  =", " =")
    initial = member.find("initializer")
    initial = "" if initial is None else re.sub(r"\s+", " ", "".join(initial.itertext())).strip()
    if kind == "define":
        parameters = [p.findtext("defname") or "" for p in member.findall("param")]
        text = "#define " + name + ("(" + ", ".join(parameters) + ")" if parameters else "")
        return text + (" " + initial if len(initial) < 40 else "")
    if kind == "typedef":
        alias = f"typedef {type_text}{name}{arguments}" if "(" in arguments else f"using {name} = {type_text}{arguments}"
        return template_of(member) + alias
    words = [template_of(member).strip()]
    words += ["static"] if member.get("static") == "yes" else []
    words += ["virtual"] if member.get("virt") in ("virtual", "pure-virtual") else []
    words += ["explicit"] if member.get("explicit") == "yes" else []
    text = " ".join(w for w in words + [type_text, squeezed(name)] if w) + arguments
    if kind == "variable" and len(initial) < 80:
        text += (" " if initial.startswith("=") else "") + initial
    return text


def is_shown(member):
    described = "".join(member.find("briefdescription").itertext()).strip()
    trivial = re.search(r"=\s*(default|delete)$", member.findtext("argsstring") or "")
    trivial = trivial or member.findtext("name").startswith("~")
    return member.get("prot") != "private" and member.get("kind") not in ("friend",) and (described or not trivial)


def members(pages, owner, items, header):
    """A list: signature, what it says."""
    lines = []
    for member in items:
        pages.need_line(member, (owner + "::" if owner else "") + member.findtext("name"))
        text = pages.description(member, header)
        if member.get("kind") == "enum":
            values = ", ".join(f"`{value.findtext('name')}`" for value in member.findall("enumvalue"))
            text = (text + "\n\n" + values).strip()
            code = "enum " + ("class " if member.get("strong") == "yes" else "") + member.findtext("name")
        else:
            code = signature(member)
        lines.append(f"- `#!cpp {code}`\n" + ("\n    " + text.replace("\n", "\n    ") + "\n" if text else ""))
    return lines


def type_section(pages, item, header):
    kind, own = item.get("kind"), pages.places[item.get("id")][1]
    name = item.findtext("compoundname") or item.findtext("qualifiedname") or own
    pages.need_line(item, name)
    lines = [f"## {own} {{ #{anchor_of(own)} }}\n"]
    bases = [base.text for base in item.findall("basecompoundref")]
    head = template_of(item) + kind + (" class" if item.get("strong") == "yes" else "") + " " + name
    lines.append(f"`#!cpp {squeezed(head + (' : ' + ', '.join(bases) if bases else ''))}`\n")
    lines.append(pages.description(item, header) + "\n")
    if kind == "enum":
        values = [(value.findtext("name"), pages.description(value, header)) for value in item.findall("enumvalue")]
        return lines + [f"- `{value}`" + (": " + text if text else "") for value, text in values] + [""]
    shown = [m for m in item.iter("memberdef") if is_shown(m)]
    shown.sort(key=lambda m: int(m.find("location").get("line")))
    return lines + members(pages, own, shown, header)


def page(pages, header):
    head = pages.description(pages.heads[header], header) if header in pages.heads else ""
    if not head:
        pages.problems.append(f"{header}:2: the header says nothing of its subject")
    items = [item for _, item in sorted(pages.items.get(header, []), key=lambda entry: entry[0])]
    lines = [f"# {header}\n", head + "\n", f"```cpp\n#include \"{header}\"\n```\n"]
    for item in items:
        if item.get("kind") in ("class", "struct", "union", "enum"):
            lines += type_section(pages, item, header)
    for title, kind in (("Aliases", "typedef"), ("Functions", "function"), ("Constants", "variable"), ("Macros", "define")):
        rest = [item for item in items if item.get("kind") == kind and is_shown(item)]
        if rest:
            lines += [f"## {title}\n"] + members(pages, "", rest, header)
    return "\n".join(lines)


def main(xml, target):
    pages = Pages(Path(xml))
    headers = sorted(pages.heads)
    for header in headers:
        path = Path(target) / (header + ".md")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(page(pages, header), encoding="utf-8")
    lines = ["# Headers\n", "The public headers, each with its types and functions.\n", "| header | subject |", "|---|---|"]
    for header in headers:
        brief = pages.heads[header].find("briefdescription")
        lines.append(f"| [{Path(header).name}]({header}.md) | {pages.text(brief, header).strip()} |")
    (Path(target) / "README.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    for problem in pages.problems or ([] if headers else ["there is no header in " + xml]):
        print(problem, file=sys.stderr)
    return 1 if pages.problems or not headers else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
