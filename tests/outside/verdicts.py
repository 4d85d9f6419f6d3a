"""One line for each thing that an outside program is asked about."""


def told(witness, names, complaints):
    """Prints what `witness` says of each; the exit code.

    `complaints` of a name are its figures in short and a list of what is wrong with it.
    """
    failed = False
    for name in names:
        try:
            figures, wrong = complaints(name)
        except Exception as error:
            figures, wrong = "unreadable", [f"{type(error).__name__}: {error}"]
        verdict = "FAILED; " + "; ".join(wrong) if wrong else "ok"
        print(f"{witness}: {name}: {figures}: {verdict}")
        failed |= bool(wrong)
    return 1 if failed else 0
