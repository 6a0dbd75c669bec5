# SPDX-License-Identifier: Apache-2.0
"""Manual pages, binnacle(1) and one for each verb, from what --help prints."""
import re

ENVIRONMENT = [
    ("BINNACLE_PLUGIN_PATH", "Folders with plugins, separated by colons, besides ../lib/binnacle of the command. Whole paths only."),
    ("BINNACLE_ALLOW_PLUGINS", "1 is --allow-plugins of every command."),
    ("BINNACLE_MPI_TIMEOUT", "Seconds after which a study under mpirun gives up a process that does not answer; 60."),
    ("NO_COLOR", "Where it is set, nothing is coloured."),
]
MANUAL = "/usr/share/binnacle/sdk/docs"
FILES = [
    ("/usr/share/binnacle/configs", "Configs to run and to copy. Paths are those of the Debian package."),
    (MANUAL, "The manual, in Markdown. README.md is its index."),
    ("/usr/lib/binnacle", "The plugins."),
]
# Of a verb: others that go before or after it, and pages of the manual beside its own.
RELATED = {
    "run": (["inspect", "check", "tune", "report", "export"], ["summary", "trust", "smoothing", "results"]),
    "inspect": (["run", "allan"], ["tutorial", "inspect"]),
    "check": (["explain", "run"], ["diagnostics", "reference"]),
    "explain": (["check", "graph", "describe"], ["reference"]),
    "list": (["describe"], ["reference"]),
    "describe": (["list", "schema"], ["reference"]),
    "create": (["describe", "check"], ["reference"]),
    "schema": (["check"], ["reference"]),
    "graph": (["explain"], ["graph"]),
    "study": (["run", "covariance", "report"], ["studies"]),
    "covariance": (["study", "observe"], ["covariance"]),
    "observe": (["covariance"], ["observability"]),
    "tune": (["run", "allan"], ["tuning", "consistent-filter"]),
    "allan": (["inspect", "tune"], ["consistent-filter"]),
    "report": (["run", "export"], ["report"]),
    "export": (["run", "report"], ["export"]),
    "verdict": (["run", "report"], ["trust"]),
    "new": (["conform", "describe"], ["first-plugin"]),
    "conform": (["new"], ["conformance", "test-a-plugin"]),
    "version": ([], ["abi-rules"]),
}
SECTIONS = {
    "run": (
        "VERDICT",
        "The last line judges each filter by its innovations, gates and covariance; it needs no reference. "
        "ok: nothing was found; that is no proof. doubtful: the estimates may be wrong; the reasons are on standard error. "
        "lost: do not use the estimates. The smoothed estimates of --smooth have the verdict of their filter. "
        "trust.md of the manual says what no verdict detects.",
    ),
}


def roff(text):
    """Text as it is: no escape, no request at the start of a line, and every minus one that can be typed."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("σ", "sigma").replace("±", "\\(+-")
    return "\n".join("\\&" + line if line[:1] in (".", "'") else line for line in text.split("\n"))


def bold(text):
    return f"\\fB{roff(text)}\\fR"


def italic(text):
    return f"\\fI{roff(text)}\\fR"


def term(label, text):
    return f".TP\n{label}\n{text}\n"


def details_of(entry):
    """The description, then what --help says in brief: choices, range, default, what else it needs or excludes."""
    parts = [roff(entry.text) + ("" if entry.text.endswith((".", "?")) else ".")]
    if entry.choices and not all(choice in entry.text for choice in entry.choices):
        parts.append("One of " + ", ".join(bold(choice) for choice in entry.choices) + ".")
    if entry.range:
        limits = re.fullmatch(r"INT in \[(\S+) - (\S+)\]", entry.range)
        parts.append(f"A whole number from {limits[1]} to {limits[2]}." if limits else "A number above zero.")
    if entry.default:
        parts.append(f"Default: {bold(entry.default)}.")
    if entry.required and entry.names[0].startswith("-"):
        parts.append("Has to be given.")
    if entry.repeated:
        parts.append("May be given several times.")
    if entry.needs:
        parts.append("Only with " + ", ".join(bold(name) for name in entry.needs) + ".")
    if entry.excludes:
        parts.append("Not together with " + ", ".join(bold(name) for name in entry.excludes) + ".")
    return "\n".join(parts)


def label_of(entry):
    if not entry.names[0].startswith("-"):
        return italic(entry.names[0])
    label = ", ".join(bold(name) for name in entry.names)
    return f"{label} {italic(entry.value)}" if entry.value else label


def header(title, version):
    return f'.\\" Made from --help by sdk/help/man_pages.py: do not edit.\n.TH {title} 1 "" "Binnacle {version}" "Binnacle"\n'


def footer_of(verb):
    status, _, streams = verb.footer.partition("\n")
    status = roff(status.removeprefix("Exit status: "))
    return f".SH EXIT STATUS\n{status}\n" + (f".PP\n{roff(streams)}\n" if streams else "")


def verb_page(verb, version):
    synopsis = verb.usage.removeprefix(f"binnacle {verb.name}").replace("[OPTIONS]", "[OPTION]...")
    page = header(f"BINNACLE-{verb.name.upper()}", version)
    page += f".SH NAME\nbinnacle\\-{verb.name} \\- {roff(verb.summary[0].lower() + verb.summary[1:])}\n"
    page += f".SH SYNOPSIS\n{bold('binnacle ' + verb.name)}{roff(synopsis)}\n"
    page += f".SH DESCRIPTION\n{roff(verb.summary)}.\n"
    if verb.positionals:
        page += ".SH ARGUMENTS\n" + "".join(term(label_of(entry), details_of(entry)) for entry in verb.positionals)
    page += ".SH OPTIONS\n" + "".join(term(label_of(entry), details_of(entry)) for entry in verb.options)
    if verb.footer:
        page += footer_of(verb)
    if verb.name in SECTIONS:
        title, text = SECTIONS[verb.name]
        page += f".SH {title}\n{roff(text)}\n"
    others, guides = RELATED[verb.name]
    names = ",\n".join([".BR binnacle (1)"] + [f".BR binnacle\\-{other} (1)" for other in others])
    files = ", ".join(roff(f"{guide}.md") for guide in [f"verbs/{verb.name}", *guides])
    return page + f".SH SEE ALSO\n{names}\n.PP\nExamples and the exact rules, in {roff(MANUAL)}: {files}\n"


def command_page(main, verbs, version):
    page = header("BINNACLE", version)
    page += f".SH NAME\nbinnacle \\- {roff(main.summary[0].lower() + main.summary[1:])}\n"
    page += f".SH SYNOPSIS\n{bold('binnacle')} {italic('VERB')} [OPTION]... [ARGUMENT]...\n"
    page += (
        ".SH DESCRIPTION\nRuns error\\-state Kalman filters for INS/GNSS and other sensors. A filter is composed by a JSON file, the config, "
        "out of state blocks, process models, measurement models, noise estimators and sources, which plugins provide. "
        "The command checks a config, runs it over recorded, live or simulated data, and judges what comes out.\n"
    )
    page += ".SH VERBS\n" + "".join(
        term(f".BR binnacle\\-{verb.name} (1)", roff(verb.summary) + ".") for verb in verbs)
    page += ".SH OPTIONS\n" + "".join(term(label_of(entry), details_of(entry)) for entry in main.options)
    page += footer_of(main)
    page += ".SH ENVIRONMENT\n" + "".join(term(bold(name), roff(text)) for name, text in ENVIRONMENT)
    page += ".SH FILES\n" + "".join(term(italic(name), roff(text)) for name, text in FILES)
    page += (
        ".SH EXAMPLES\n.nf\nbinnacle run /usr/share/binnacle/configs/quickstart.json\n"
        "binnacle inspect imu.csv gnss.csv \\-\\-write my.json\nbinnacle run my.json \\-\\-out out\n.fi\n"
    )
    others = ",\n".join(f".BR binnacle\\-{verb.name} (1)" for verb in verbs)
    return page + f".SH SEE ALSO\n{others}\n"


def pages(main, verbs, version):
    """File name and text of each page."""
    yield "binnacle.1", command_page(main, verbs, version)
    for verb in verbs:
        yield f"binnacle-{verb.name}.1", verb_page(verb, version)
