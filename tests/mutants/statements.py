# SPDX-License-Identifier: Apache-2.0
"""Statements of a C++ source that clang-format laid out, and the mutants of each. A tokenizer, no compiler: what it takes
for something else does not compile, and draw.py drops it."""
import re
from collections import namedtuple

TOKEN = re.compile(
    r'(?P<skip>//[^\n]*|/\*.*?\*/|^[ \t]*\#(?:[^\n\\]|\\.|\\\n)*|\s+)'
    r'|(?P<string>(?:u8|[uUL])?R"(?P<mark>[^()\\\s]{0,16})\(.*?\)(?P=mark)"|(?:u8|[uUL])?"(?:[^"\\\n]|\\.)*")'
    r"|(?P<number>(?:0[xXbB][0-9a-fA-F']+|(?:\d[\d']*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\w*)"
    r"|(?P<char>'(?:[^'\\\n]|\\.)+')|(?P<name>[A-Za-z_]\w*)"
    r'|(?P<op><<=|>>=|<=>|->\*|\.\.\.|::|->|\+\+|--|<<|>>|[-+*/%&|^<>=!]=|&&|\|\||.)', re.S | re.M)
OPERATORS = {"+": ["-"], "-": ["+"], "*": ["/"], "/": ["*"], "<": ["<=", ">="], "<=": ["<", ">"], ">": [">=", "<="], ">=": [">", "<"],
             "==": ["!="], "!=": ["=="], "&&": ["||"], "||": ["&&"], "+=": ["-="], "-=": ["+="], "*=": ["/="], "/=": ["*="]}
OF_TYPES = {"const", "unsigned", "signed", "long", "short", "typename"}
NO_STATEMENT = {"using", "static_assert", "typedef", "struct", "class", "enum", "union", "template", "static", "constexpr", "break",
                "goto", "extern", "thread_local"}
IN_FRONT = {"if", "for", "while", "switch", "constexpr", "catch"}
NO_MEMBER = NO_STATEMENT - {"static", "thread_local"} | {"friend", "operator", "concept", "namespace", "="}


Token = namedtuple("Token", "kind text start end")
# A statement, a condition or an initializer: the tokens first … last, of which `own` are in no code inside of it.
Record = namedtuple("Record", "kind first last own is_guarded has_code")


class Source:
    def __init__(self, text):
        self.text, self.records, self.pairs, self.in_template, opened = text, [], {}, set(), []
        self.tokens = [Token("string" if m.lastgroup == "mark" else m.lastgroup, m.group(), m.start(), m.end())
                       for m in TOKEN.finditer(text) if m.lastgroup != "skip"]
        for i, token in enumerate(self.tokens):
            if token.text in ("(", "[", "{"):
                opened.append(i)
            elif token.text in (")", "]", "}"):
                self.pairs[i] = opened.pop()
                self.pairs[self.pairs[i]] = i
        for i in range(1, len(self.tokens)):
            if self.at(i) == "<" and self.at(i - 1) != "operator" and (self.at(i - 1) == "template" or not self.is_spaced(i)):
                self._template(i)
        self.code = {i for i in self.pairs if self.at(i) == "{" and self._is_code(i)}
        self.in_code = set()
        for i in sorted(self.code):
            if i not in self.in_code or self.at(i - 1) in ("]", ")") or "->" in map(self.at, range(i - 9, i)):
                self._function(i)
        for i in range(2, len(self.tokens)):
            if self.at(i) == "=" and i not in self.in_code and i not in self.in_template:
                self._member(i)

    def at(self, i):
        return self.tokens[i].text if 0 <= i < len(self.tokens) else ""

    def line(self, i):
        return self.text.count("\n", 0, self.tokens[i].start) + 1

    def slice(self, first, last):
        return self.text[self.tokens[first].start:self.tokens[last].end]

    def is_spaced(self, i):
        return self.text[self.tokens[i].start - 1].isspace() and self.text[self.tokens[i].end:][:1].isspace()

    def one_line(self, first, last, changed=None):
        """The text of the tokens first … last, some of them changed, without comments and newlines."""
        gap = {i: " " if self.tokens[i].start > self.tokens[i - 1].end else "" for i in range(first + 1, last + 1)}
        return "".join(gap.get(i, "") + (changed or {}).get(i, self.at(i)) for i in range(first, last + 1))

    def behind(self, i):
        """The next token, behind the brackets that this one opens."""
        return self.pairs[i] + 1 if self.at(i) in ("(", "[", "{") or (self.at(i) == "<" and i in self.pairs) else i + 1

    def outer(self, first, end):
        while first < end:
            yield first
            first = self.behind(first)

    def _template(self, i):
        depth, j = 0, i
        while j < len(self.tokens) and self.at(j) not in (";", "{", "}", ")"):
            depth += {"<": 1, ">": -1, ">>": -2}.get(self.at(j), 0)
            if depth <= 0:
                self.in_template.update(range(i, j + 1))
                self.pairs.setdefault(i, j)
                return
            j = self.behind(j) if self.at(j) != "<" else j + 1

    def _is_code(self, i):
        """Whether braces are those of a function, of a lambda, or of what a function has in braces behind `if (…)`."""
        if self.at(i - 1) in ("]", ")", "mutable", "noexcept", "override", "const"):
            return True
        j = i - 1
        while self.tokens[j].kind in ("name", "number") or self.at(j) in ("::", "<", ">", ">>", "*", "&", ","):
            j -= 1
        return self.at(j) == "->" and (self.at(j - 1) == ")" or self.at(j - 1) in ("const", "mutable", "noexcept"))

    def _function(self, i):
        if i in self.in_code and self.at(self.pairs[i - 1] - 1 if self.at(i - 1) == ")" else i) in IN_FRONT:
            return  # of the function around it
        head = i
        while head > 0 and self.at(head - 1) not in (";", "{", "}"):
            head -= 1
        self.in_code.update(range(i, self.pairs[i] + 1))
        if i not in self.in_template and not {"constexpr", "consteval"} & set(map(self.at, range(head, i))):
            self._block(i)

    def _member(self, i):
        head = i
        while head > 0 and self.at(head - 1) not in (";", "{", "}", ":", "("):
            head -= 1
        end = i
        while end < len(self.tokens) and self.at(end) not in (";", ")", "}"):
            end = self.behind(end)
        if self.at(head - 1) != "(" and self.at(end) == ";" and not NO_MEMBER & set(map(self.at, range(head, i))):
            self._record("initializer", i + 1, end - 1)

    def _block(self, i):
        end, j, is_guarded = self.pairs[i], i + 1, False
        while j < end:
            word, begin = self.at(j), j
            if word in ("if", "for", "while", "switch", "catch"):
                j += self.at(j + 1) == "constexpr"
                if word not in ("switch", "catch") and j == begin:
                    self._condition(word, j + 2, self.pairs[j + 1])
                is_guarded, j = word == "if" and j == begin, self.pairs[j + 1] + 1
                continue
            if word == "{":
                self._block(j)
                j = self.pairs[j] + 1
            elif word in ("else", "do", "try", ";") or (word == "[" and self.at(j + 1) == "["):
                j = self.behind(j)
            else:
                stop = (":",) if word in ("case", "default") else (";",)
                while self.at(j) not in stop and j < end:
                    j = self.behind(j)
                if stop == (";",) and word not in NO_STATEMENT:
                    kind = word if word in ("return", "throw", "continue") else "declaration" if self.named(begin, j) else "expression"
                    self._record(kind, begin, j, is_guarded and self.at(j + 1) != "else")
                j += 1
            is_guarded = False

    def _condition(self, word, first, close):
        ends = [j for j in self.outer(first, close) if self.at(j) == ";"] + [close]
        tested = len(ends) - 1 if word != "for" else 1 if len(ends) == 3 else -1
        for k, (a, b) in enumerate(zip([first, *(e + 1 for e in ends)], ends)):
            if b > a and k < 2:
                self._record("condition" if k == tested and not self.named(a, b) else "initializer", a, b - 1)

    def _record(self, kind, first, last, is_guarded=False):
        own, j = [], first
        while j <= last:
            if j not in self.code:
                own.append(j)
            j = self.pairs[j] + 1 if j in self.code else j + 1
        self.records.append(Record(kind, first, last, own, is_guarded, len(own) <= last - first))

    def named(self, first, end):
        """The token behind the name that is declared; None if nothing is."""
        j, types = first, 0
        while j < end and self.tokens[j].kind == "name":
            if types and self.at(j + 1) in ("=", "{", "(", "[", ";", ",") and self.at(j - 1) != "::":
                return j + 1
            if types and self.at(j - 1) not in ("::", *OF_TYPES) and self.at(j) not in OF_TYPES:
                return None
            types += self.at(j) not in ("const", "typename")
            j = self.behind(j + 1) if j + 1 in self.pairs and self.at(j + 1) == "<" else j + 1
            while self.at(j) in ("::", "*", "&", "&&", "const") and not (self.at(j) != "const" and self.is_spaced(j)):
                j += 1
            if self.at(j - 1) in ("*", "&", "&&", "const") and self.at(j + 1) in ("=", "{", "(", "[", ";", ","):
                return j + 1
            if self.at(j) == "[" and "auto" in map(self.at, range(first, j)):
                return self.pairs[j] + 1
        return None


# ---- mutants

def changed_number(text, rng):
    match = re.fullmatch(r"(0|[1-9][\d']*)([uUlLzZ]*)", text)
    if match:
        value = int(match[1].replace("'", ""))
        return f"{1 if value == 0 else rng.choice([0, 2]) if value == 1 else 2 * value}{match[2]}"
    match = re.fullmatch(r"((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)([fF]?)", text)
    return match and repr(float(match[1]) * rng.choice([0.5, 2]) or 1.0) + match[2]


def sites(source, rng):
    """(record, kind, token, new text) of each mutant of a source."""
    at = source.at
    for record in source.records:
        begin, kind, is_whole = record.first, record.kind, record.kind in ("condition", "expression", "return") and not record.has_code
        has_text = any(source.tokens[i].kind == "string" for i in record.own)
        if kind == "declaration":
            begin = source.named(record.first, record.last)
            is_whole = at(begin) == "=" and not record.has_code and not {"&", "&&", "["} & set(map(at, source.outer(record.first, begin))) \
                and "," not in map(at, source.outer(begin, record.last))
        for i in record.own if kind != "throw" else []:
            token, before = source.tokens[i], source.tokens[i - 1]
            if i < begin or i in source.in_template:
                continue
            if token.kind == "number" and not (kind == "declaration" and i == begin + 1 and before.text == "["):
                changed = changed_number(token.text, rng)
                if changed:
                    yield record, "constant", i, changed
            elif is_whole and token.text in OPERATORS and token.kind == "op":
                if source.is_spaced(i) and not (token.text == "+" and has_text):
                    yield record, "operator", i, rng.choice(OPERATORS[token.text])
                elif token.text == "-" and (before.kind == "op" and before.text not in (")", "]", "}") or before.text == "return"):
                    yield record, "sign", i, ""
        if kind == "condition":
            yield record, "negated", record.first, ""
        if kind == "expression" or kind in ("return", "throw", "continue") and record.is_guarded:
            yield record, "dropped", record.first, ""


def rewritten(source, record, kind, at, new, number):
    """[(start, end, text)]: what puts the mutant behind its switch. Lines keep their numbers."""
    first, last, on, tokens = record.first, record.last, f"binnacle_mutants::on({number})", source.tokens
    start, end = tokens[first].start, tokens[last].end
    original, mutated = source.slice(first, last), source.one_line(first, last, {at: new})
    if kind == "constant":
        return [(tokens[at].start, tokens[at].end, f"({on} ? {new} : {tokens[at].text})")]
    if kind == "negated":
        return [(start, start, f"({on} != static_cast<bool>("), (end, end, "))")]
    if kind == "dropped":
        return [(start, start, f"{{ if (!{on}) {{ "), (end, end, " } }")]
    if record.kind == "declaration":
        equals = source.named(first, last)
        words = source.one_line(first, equals - 2).removeprefix("const ")
        cast = "" if "auto" in words else f"static_cast<{words}>"
        mutated, original = source.one_line(equals + 1, last - 1, {at: new}), source.slice(equals + 1, last - 1)
        return [(tokens[equals + 1].start, tokens[last - 1].end, f"{on} ? {cast}({mutated}) : {cast}({original})")]
    if record.kind == "condition":
        return [(start, end, f"({on} ? static_cast<bool>({mutated}) : static_cast<bool>({original}))")]
    return [(start, end, f"{{ if ({on}) {{ {mutated} }} else {{ {original} }} }}")]
