:- module(facetlog_prove, [ evaluate/3,       % +Test, +Module, -Proof
                            all_proved/4      % +Proofs, -State, -Low, -High
                          ]).

/** <module> Tests into proofs

Evaluating a test gives

    proof(State, Low, High, Test, Detail, Children)

State, Low and High are those of outline/3 (say.pl), from the proofs of all parts. Detail is

  - compared(Value, Sd, Kind, Within, Margin): Within is near(Target, Tolerance),
    between(Low, High), at_least(Limit) or at_most(Limit), all in numbers, or fading(Within, Width)
    or soft(Within, Width) of one of these; Margin is
    margin(Side, Distance, Sd): the signed distance to the nearer edge of the region, negative
    outside it, with the deviation of that difference; Side is below or above, where that edge is;
  - uncertain(Value, Sd, Kind, Within, Margin): the same, but it is too uncertain to say;
  - missing(Measure, Cause): what the scene does not know, and why (missing_because/2);
  - fact(Truth, Cause): a relation, true, false or unknown; Cause is none unless it is unknown;
  - short: a word of the model or the vocabulary, whose meaning is the only child; short(Shape) where a
    piece is not of the shape that is wanted, but of another, board, bar or block;
  - counted(Holding, Open, Deciding): how many groups hold and how many may; Deciding is the member
    whose proof decides, or none. The children prove the best member of each group, the best first;
  - judged(Cause): what another model says of a thing;
  - all, any, not, if_known, not_applied, implies, expect(Weight): what became of the children. The
    Test of such a step does not repeat them: it is what form/4 shows.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(library(error)).
:- use_module(facetlog_kb(degrees)).
:- use_module(facetlog_kb(say)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(model_test)).
:- use_module(facetlog(vocabulary)).

%!  evaluate(+Test, +Module, -Proof) is det.
%
%   Proof of Test in the current scene.
%
%   @error as outline/3

evaluate(Test, Module, Proof) :-
    sort_of(Test, Module, Sort),
    proof_of(Sort, Test, Module, Proof).

proof_of(comparison(Measure, Bounds), Test, Module, proof(State, Low, High, Test, Detail, [])) :-
    compared_in_detail(Measure, Bounds, Module, Test, said(State, degree(Low, High, _)), Detail).
proof_of(joined(Join, Parts), Test, Module, proof(State, Low, High, Shown, Detail, Children)) :-
    form(Test, _, _, Shown),
    part_proofs(Parts, Module, Proofs, Saids),
    (   left_open(Parts)
    ->  State = unknown, Low = 0, High = 1
    ;   all_together(Join, Saids, said(State, degree(Low, High, _)))
    ),
    shown(Join, Shown, Proofs, Saids, Detail, Children).
proof_of(relation, Test, Module, proof(State, Low, High, Test, Detail, Children)) :-
    relation(Test, Truth),
    said(Test, Module, full, said(State, degree(Low, High, _))),
    (   State == fails,
        rests_on(Test, Meaning),
        evaluate(Meaning, Module, Proof),
        Proof = proof(fails, _, _, _, _, _)
    ->  Detail = short,
        Children = [Proof]
    ;   ( Truth == unknown -> missing_because(Test, Cause) ; Cause = none ),
        Detail = fact(Truth, Cause),
        Children = []
    ).
proof_of(is_a(Thing, Model), Test, _, proof(State, Low, High, Test, judged(Cause), [])) :-
    model_outcome(Thing, Model, outcome(State, Low, High, Cause)).
proof_of(meaning(Meaning), Test, Module, proof(State, Low, High, Test, Detail, [Proof])) :-
    evaluate(Meaning, Module, Proof),
    Proof = proof(State, Low, High, _, _, _),
    (   State == fails,
        other_shape(Test, Module, Shape)
    ->  Detail = short(Shape)
    ;   Detail = short
    ).

%   The shape that a piece is of where Test, that it is of another, fails.
other_shape(Test, Module, Shape) :-
    shape_test(_, _, Test),
    !,
    arg(1, Test, Piece),
    shape_test(Shape, Piece, Other),
    state(Other, Module, holds),
    !.

shape_test(board, Piece, board(Piece)).
shape_test(bar, Piece, bar(Piece)).
shape_test(block, Piece, block(Piece)).

%!  all_proved(+Proofs, -State, -Low, -High) is det.
%
%   What Proofs say together, as those of the parts of all/1.

all_proved(Proofs, State, Low, High) :-
    said_by(Proofs, Saids),
    all_together(all, Saids, said(State, degree(Low, High, _))).

                 /*******************************
                 *             PARTS            *
                 *******************************/

%   Proofs of all parts, of groups group(Members) with Member-Proof for each; Saids is what they say.
part_proofs(tests(Tests), Module, Proofs, Saids) :-
    proofs(Tests, Module, Proofs, Saids).
part_proofs(over([X], List, Test), Module, Proofs, Saids) :-
    findall(Test, member(X, List), Tests),
    proofs(Tests, Module, Proofs, Saids).
part_proofs(over([X, Y], List, Test), Module, Proofs, Saids) :-
    findall(Test, ( append(_, [X|Rest], List), member(Y, Rest) ), Tests),
    proofs(Tests, Module, Proofs, Saids).
part_proofs(groups(X, Groups, Test), Module, Proofs, Saids) :-
    must_be(list(list), Groups),
    findall(Group-Tests,
            ( member(Group, Groups), findall(Test, member(X, Group), Tests) ),
            Each),
    group_proofs(Each, Module, Proofs, Saids).

part_proofs(closed(Test, Parts), Module, Proofs, [Closed|Saids]) :-
    evaluate(Test, Module, Proof),
    said_by([Proof], [Closed]),
    part_proofs(Parts, Module, Proofs, Saids).

proofs(Tests, Module, Proofs, Saids) :-
    maplist(evaluate_in(Module), Tests, Proofs),
    said_by(Proofs, Saids).

evaluate_in(Module, Test, Proof) :-
    evaluate(Test, Module, Proof).

%   By how much a test fails plays no part in a proof.
said_by(Proofs, Saids) :-
    findall(said(State, degree(Low, High, 0)), member(proof(State, Low, High, _, _, _), Proofs),
            Saids).

group_proofs([], _, [], []).
group_proofs([Group-Tests|Each], Module, [group(Members)|Groups], [Said|Saids]) :-
    proofs(Tests, Module, Proofs, Parts),
    pairs_keys_values(Members, Group, Proofs),
    all_together(any, Parts, Said),
    group_proofs(Each, Module, Groups, Saids).

%   A proof has all parts, also those after which nothing can change.
all_together(Join, Saids, Said) :-
    start(Join, full, Sum0),
    all_joined(Saids, Join, Sum0, Sum),
    together(Join, full, Sum, Said).

all_joined([], _, Sum, Sum).
all_joined([Said|Saids], Join, Sum0, Sum) :-
    joined(Join, full, Sum0, Said, Sum1),
    all_joined(Saids, Join, Sum1, Sum).

                 /*******************************
                 *         WHAT IS SHOWN        *
                 *******************************/

%   shown(Join, Shown, Proofs, Saids, Detail, Children)
shown(all, _, Proofs, _, all, Proofs).
shown(any, Shown, Proofs, _, Detail, Children) :-
    (   Shown == implies
    ->  Proofs = [proof(_, _, _, _, _, [Where]), Then],
        Detail = implies,
        Children = [Where, Then]
    ;   Detail = any,
        Children = Proofs
    ).
shown(not, _, Proofs, _, not, Proofs).
shown(if_known, _, Proofs, _, Detail, Proofs) :-
    Proofs = [proof(State, _, _, _, _, _)],
    ( State == unknown -> Detail = not_applied ; Detail = if_known ).
shown(expect(Weight), _, Proofs, _, expect(Weight), Proofs).
shown(at_least(Count), _, Groups, Saids, Detail, Children) :-
    shown_groups(at_least(Count), Groups, Saids, Detail, Children).
shown(at_least_in(Count), _, Groups, [_|Saids], Detail, Children) :-
    shown_groups(at_least_in(Count), Groups, Saids, Detail, Children).
shown(at_most(Count), _, Groups, Saids, Detail, Children) :-
    shown_groups(at_most(Count), Groups, Saids, Detail, Children).

shown_groups(Join, Groups, Saids, counted(Holding, Open, Deciding), Proofs) :-
    counted(Saids, Holding, Open),
    findall(Rank-(Member-Proof),
            ( member(group(Members), Groups), best_member(Members, Rank, Member, Proof) ),
            Best0),
    keysort(Best0, Best),
    pairs_values(Best, Named),
    pairs_values(Named, Proofs),
    deciding(Join, Place),
    ( nth1(Place, Named, Member-_) -> Deciding = Member ; Deciding = none ).

%   Of members of one rank the first.
best_member(Members, Rank, Member, Proof) :-
    findall(R-(M-P), ( member(M-P, Members), rank(P, R) ), Ranked),
    keysort(Ranked, [Rank-(Member-Proof)|_]).

%   In the order of terms 0.0 and 0 differ, and so would -0.0.
rank(proof(State, Low, High, _, _, _), rank(Order, LessLow, LessHigh)) :-
    order(State, Order),
    LessLow is 0.0 - Low,
    LessHigh is 0.0 - High.

order(holds, 0).
order(unknown, 1).
order(fails, 2).
