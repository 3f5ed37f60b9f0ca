"""What recorders and nodes said on the bus and did, held against what the record then has.

Of each epoch truth.json says, as a witness beside the bus saw it:

    openings   runs of the node that called it theirs
    obeyed     incarnations of the recorders that the node took as its owner or gave blocks back to, each change
    promised   block through which this recorder's acknowledgements called it durable
    declared   [{"sequence", "promised", "released", "may_lack_more"}]: when this recorder declared the gap with this
               number, it had promised so much, and any recorder so much; the last one is true if by then the node was
               dead or its own disk had failed, so that it may have lost what nobody has
"""

DECLARED_BY_RECORDERS = ("lost_at_node", "node_crash")


def broken_promises(said, epoch):
    """Lines.  @param said  the entry of truth.json   @param epoch  what the record holds of it, or None"""
    if int(said["openings"]) != 1:
        yield f'{said["openings"]} runs of the node had this epoch'
    for before, after in zip(said["obeyed"], said["obeyed"][1:]):
        if after < before:
            yield f"the node obeyed recorder {after} after recorder {before}"
    recorded = epoch.last_sequence if epoch else 0
    if said["promised"] > recorded:
        yield f'called durable through block {said["promised"]}, recorded through {recorded}'
    if epoch:
        declared = {entry["sequence"]: entry for entry in said["declared"]}
        for gap in epoch.gaps:
            if gap["cause"] in DECLARED_BY_RECORDERS:
                yield from _of_gap(gap, declared.get(gap["last_block"]))


def _of_gap(gap, then):
    first, last = gap["first_block"], gap["last_block"]
    if then is None:
        yield f"gap {last} is one that its recorder never declared"
        return
    if then["promised"] >= first:
        yield f'blocks {first} to {last} are declared lost; through {then["promised"]} they were called durable'
    # A node that lives gives back what a recorder called durable; what nobody did is lost through its fault.
    if gap["cause"] == "lost_at_node" and then["released"] < last and not then["may_lack_more"]:
        yield f'the node gave back blocks through {last}; through {then["released"]} they were called durable'
