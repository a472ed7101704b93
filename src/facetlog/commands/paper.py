"""`facetlog demo --paper`: the paper's experiment as a page."""

from pathlib import Path

import typer

from facetlog.commands.shared import NO, YES
from facetlog.degree_plot import check_plots
from facetlog.output_folder import check_replaceable
from facetlog.perception.step_clock import StepClock
from facetlog.terminal import show_progress, show_times

__all__ = ["run_paper_experiment"]


def run_paper_experiment(out: Path, seed: int) -> int:
    """Run the experiment and write its page to the folder `out`; return the exit code."""
    from facetlog.kb.explaining.verdict_text import format_holding
    from facetlog.paper.experiment import run_experiment
    from facetlog.paper.page import PAGE_FILE, write_paper_page

    check_replaceable(out)
    check_plots()
    clock = StepClock()
    with show_progress() as progress:
        run = run_experiment(seed, progress, clock)
    with clock.step("write page"):
        write_paper_page(out, run, seed)
    show_times(clock)
    best = run.found.recognition.best
    typer.echo(format_holding(v.summary for v in best))
    typer.echo(f"{out / PAGE_FILE}: the paper's figures 8 to 14 from this run")
    return YES if best else NO
