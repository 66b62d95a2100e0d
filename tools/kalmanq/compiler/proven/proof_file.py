"""NAME_proof.txt: what was proven of a filter, of which class, by how many covariances."""

from __future__ import annotations

import decimal

import numpy as np

from kalmanq.compiler.proven import costs
from kalmanq.compiler.proven.product import MARGIN, RECORD, RECORDS, Product, ram_of
from kalmanq.compiler.proven.rounding import FAR
from kalmanq.firmware.costs import CORES
from kalmanq.firmware.designs import TOLERABLE
from kalmanq.run.resolution import told_of

FEW = 3  # sigma


def lines_of_class(product: Product) -> list[str]:
    plan = product.plan
    beyond = f"Beyond that the mean goes on, with {plan.upper}_SIGMA_SATURATED"
    stays = [f"    {beyond}, and", "    the covariance stays one of these, for ever"] if plan.carries_covariance else [f"    {beyond}."]
    if not plan.max_gap:
        return ["samples that may be missing: none.", *stays]
    chosen = " (as many as it takes to settle: the model gives no min_run)" if plan.model.gaps.min_run is None else ""
    return [f"samples that may be missing: 1 to {plan.max_gap} in a row, {plan.min_run} measured ones at least between "
            f"two gaps{chosen};", "    the first gap at any time" + (", of a sample any components." if plan.partial else "."), *stays]


def remarks(product: Product) -> list[str]:
    """For the head of the C file"""
    plan, proof = product.plan, product.proof
    settles = f"; settled after {plan.rows} samples in a row, then of constant gain" if plan.carries_covariance else ""
    lines = ["", f"Form: {plan.form.name}{settles}.", *lines_of_class(product), *losses(product)]
    for how, found in proof.found.items():
        lines.append(f"{found.count} covariances{f' ({how})' if how else ''}, that is all: positive definite, the "
                     f"least scaled pivot {found.pivot:.1e}; within {found.error:.1e} sigma_i sigma_j.")
    lines += [*(f"{what[0].upper()}{what[1:]}: {said}." for what, said in of_means(product)),
              *(f"{one}." for one in of_measurements(product))]
    lines += [f"Not {one.form}: {one.reason}." for one in product.refused]
    return [*lines, "", *flags(product)]


def of_means(product: Product) -> list[tuple[str, str]]:
    """What was seen of records of the model, and at the ends of the ranges: the largest figure first"""
    proof, gaps = product.proof, " with gaps" if product.plan.max_gap else ""
    cure = "declare ranges, or take q31" if product.wanted.arithmetic == "f32" else "smaller ranges"
    seen = [(track.worst, ("means", f"{track.worst:.1e} sigma at most over {which} model{gaps}, "
                           f"{track.last:.1e} settled{_cure(track.worst, cure)}"))
            for track, which in ((proof.wandering, f"{RECORDS} records of {RECORD} rows of the"),
                                 (proof.track, f"{RECORD} rows of the damped"))]
    known = zip([proof.rounding, *([proof.ends.worst] if proof.ends else [])], at_their_ranges(product))
    return [line for _, line in sorted([*known, *seen], key=lambda one: -one[0])]


def at_their_ranges(product: Product) -> list[tuple[str, str]]:
    """What words cost where states and innovations are large, and what that is"""
    proof, model, is_float = product.proof, product.model, product.wanted.arithmetic == "f32"
    where = "any measurements and controls within their ranges"
    if is_float:
        where = "states and innovations at their ranges"
        where += "" if all(one.range for one in model.states) else f", or {FAR} sigma where they have none"
    lines = [("a float has 24 bits" if is_float else "words of coefficients",
              f"{no_less(proof.rounding)} sigma of a settled mean at most, {where}"
              f"{_cure(proof.rounding, 'smaller ranges, or q31' if is_float else 'smaller ranges')}")]
    if proof.ends:
        lines.append(("at the ends of ranges", f"means {proof.ends.worst:.1e} sigma over {RECORDS} records of "
                      f"{RECORD // RECORDS} rows of measurements and controls there, rows before the covariance has "
                      f"settled among them{_cure(proof.ends.worst, 'smaller ranges')}"))
    return lines


def _cure(loss: float, cure: str) -> str:
    return f"; more than {TOLERABLE:.0e}: {cure}" if loss > TOLERABLE else ""


def warnings(product: Product) -> list[str]:
    """What may be too much: errors of means, ranges that are too narrow"""
    return [f"{what}: {said}" for what, said in of_means(product) if "; more than " in said] + of_measurements(product)


def of_measurements(product: Product) -> list[str]:
    """Those that will be refused however well the filter knows the states; those that are coarse beside their noise"""
    arithmetic = product.wanted.arithmetic
    coarse = told_of(product.model, arithmetic)
    sigmas = [float(value.sqrt()) for value in np.diag(product.plan.settled.variance)]
    return [f"range of {one.name}: {one.range:g} is less than {FEW:g} sigma of its innovation, {FEW * sigma:.3g}: what "
            "is beyond is refused at run time" for one, sigma in zip(product.model.measurements, sigmas)
            if one.range and one.range < FEW * sigma] + ([f"measurements are coarse in {arithmetic}: {coarse}"] if coarse else [])


def no_less(value: float) -> str:
    """Two digits that are not below the value, of which the search has told four"""
    rounded = decimal.Context(prec=2, rounding=decimal.ROUND_CEILING).create_decimal_from_float(1.0005 * value)
    return f"{float(rounded):.1e}"


def losses(product: Product) -> list[str]:
    loss = product.proof.losses
    if not loss:
        return []
    gap = f"{loss[1]:.3g} times after a gap, " if product.plan.max_gap else ""
    return [f"Sigma is at most {loss[0]:.3g} times the optimal filter's after the start, {gap}the same once settled."]


def flags(product: Product) -> list[str]:
    name = product.plan.name
    cmake = f"    CMake     set_source_files_properties({name}.c PROPERTIES COMPILE_OPTIONS"
    lines = ["Compile with -O2, and on a core that has fused multiply-add with -ffp-contract=fast:",
             f'{cmake} "-O2;-ffp-contract=fast")',
             f"    make      {name}.o: CFLAGS += -O2 -ffp-contract=fast"]
    if product.wanted.arithmetic == "q31":
        lines = ["Compile with -O2:", f"{cmake} -O2)",
                 f"    make      {name}.o: CFLAGS += -O2"]
    return lines


def proof_text(product: Product) -> str:
    plan, proof, margin = product.plan, product.proof, MARGIN[product.wanted.arithmetic]
    lines = [f"{plan.name}: {plan.form.name}, {product.wanted.arithmetic}", "", *lines_of_class(product),
             *losses(product), f"settles in {plan.rows} samples in a row, to 1e-6 sigma_i sigma_j", ""]
    for how, found in proof.found.items():
        lines += [*([f"{how}:"] if how else []), f"covariances                  {found.count}, and no more",
                  f"not positive definite        {found.bad}", f"least scaled pivot           {found.pivot:.3e}",
                  f"worst error                  {found.error:.3e} sigma_i sigma_j",
                  f"exact ones of one word       {found.merged:.3e} apart at most", ""]
    if proof.found:
        lines.append(f"promise                      {no_less(margin * proof.worst.error)} sigma_i sigma_j"
                     + (f" ({margin} times the worst: compilers contract as they like)" if margin > 1 else
                        " (on every core)"))
    lines += [*(f"{what:<28} {said}" for what, said in of_means(product)),
              *of_measurements(product),
              f"RAM                          {ram_of(plan)} bytes", ""]
    lines += [*means(product), *costs_of(product)]
    lines += [f"refused: {one.form}: {one.reason}" for one in product.refused]
    return "\n".join([*lines, *flags(product), ""])


def costs_of(product: Product) -> list[str]:
    """On the cores that were measured, by the operations of the C"""
    made = costs.estimates(product.plan)
    if not made:
        return ["what it costs is not estimated of a filter of constant gain or with --nis, --lag or --partial", ""]
    lines = ["about what it costs: instructions of a row in two calls, of a settled step, bytes of the file.  Behind "
             "each, how far", "off such an estimate was at most, of more than 100 filters on that emulated core, with "
             "gcc 12 at that level:"]
    for (core, level), cost in made.items():
        lines.append(f"    {CORES[core]:<18} -{level}  " + "  ".join(f"{cell:>12}" for cell in cost.cells))
    return [*lines, ""]


def means(product: Product) -> list[str]:
    if not product.plan.bounds:
        return []
    rows = [f"    {one.name:<24} {bound:.6g}" for one, bound in zip(product.model.states, product.plan.bounds)]
    return ["largest means, of the worst measurements and controls within their ranges (L1 norm of the closed loop's "
            "impulse", "response over all declared gaps):", *rows, ""]
