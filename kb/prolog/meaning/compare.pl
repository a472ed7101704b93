:- module(facetlog_compare, [ comparison/3,         % ?Test, ?Measure, ?Bounds
                              compared/6,           % +Measure, +Bounds, +Module, +Test, +Want, -Said
                              compared_in_detail/6  % +Measure, +Bounds, +Module, +Test, -Said, -Detail
                            ]).

/** <module> Measured values against their limits

A quantity and its limits become a region, and that a state with its probability.

A region is region(Margins, Within, Width): Margins are one(Side, Distance, Variance) or
two(Below, BelowVar, Above, AboveVar), the signed distances to its edges, all >= 0 inside. Within has the
limits in numbers, near(Target, Tolerance), between(Low, High), at_least(Limit) or at_most(Limit). Width
is `sharp`, or how wide the slopes of the edges are, whose middles, where the membership is 1/2, the
distances are to: width(Width) begins at the limit and falls beyond it, and the middle of the slope decides
the state; soft(Width) has the limit in its middle, and changes degrees alone.
*/

:- use_module(library(lists)).
:- use_module(library(error)).
:- use_module(facetlog_kb(static)).
:- use_module(facetlog_kb(degrees)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(fading)).
:- use_module(facetlog(vocabulary)).

% Arithmetic is most of the work: compiled, it takes half the time. The flag ends with the file.
:- set_prolog_flag(optimise, true).

%!  comparison(?Test, ?Measure, ?Bounds) is nondet.
%
%   Test compares Measure with Bounds, whose arguments are expressions.

comparison(near(M, Target, Tolerance), M, near(Target, Tolerance)).
comparison(between(M, Low, High), M, between(Low, High)).
comparison(at_least(M, Limit), M, at_least(Limit)).
comparison(at_most(M, Limit), M, at_most(Limit)).
comparison(fading(Test, Width), M, fading(Bounds, Width)) :-
    Test \= fading(_, _),              % nor a variable
    Test \= soft(_, _),
    comparison(Test, M, Bounds).
comparison(soft(Test, Share), M, soft(Bounds, Share)) :-
    Test \= fading(_, _),
    Test \= soft(_, _),
    must_be(number, Share),             % arithmetic would work out what a clause computed
    must_be(between(0.0, 1.0), Share),
    comparison(Test, M, Bounds).

%!  compared(+Measure, +Bounds, +Module, +Test, +Want, -Said) is det.
%
%   What is said (degrees.pl) of Test, which compares Measure with Bounds.
%
%   @error type_error(comparable, Test) if a length is compared with a bare number, or the like.

compared(Measure, Bounds, Module, Test, Want, Said) :-
    (   static(hangs_on_space(Test, Measures)),
        any_open(Measures)
    ->  compared_as(free, Measure, Bounds, Module, Test, Want, IfFree),
        compared_as(full, Measure, Bounds, Module, Test, Want, IfFull),
        either_way(Want, IfFree, IfFull, Said)
    ;   compared_as(stated, Measure, Bounds, Module, Test, Want, Said)
    ).

compared_as(Reading, Measure, Bounds, Module, Test, Want, Said) :-
    (   value(Measure, Module, Reading, Quantity),
        region(Bounds, Module, Reading, Quantity, Test, Region)
    ->  judged(Want, Region, Measure, Said)
    ;   plain(Want, unknown, Said)
    ).

                 /*******************************
                 *            REGIONS           *
                 *******************************/

region(near(Target, Tolerance), Module, Reading, Value, Test,
       region(two(Below, Var, Above, Var), near(T, W), sharp)) :-
    limit(Target, Module, Reading, Value, Test, T, R),
    limit(Tolerance, Module, Reading, Value, Test, W, Q),
    Value = quantity(V, S, _),
    Var is S + R + Q,
    Below is V - T + W,
    Above is T + W - V.
region(between(Low, High), Module, Reading, Value, Test,
       region(two(Below, BelowVar, Above, AboveVar), between(L, H), sharp)) :-
    limit(Low, Module, Reading, Value, Test, L, R),
    limit(High, Module, Reading, Value, Test, H, Q),
    Value = quantity(V, S, _),
    Below is V - L,
    BelowVar is S + R,
    Above is H - V,
    AboveVar is S + Q.
region(at_least(Limit), Module, Reading, Value, Test, region(one(below, Below, Var), at_least(L), sharp)) :-
    limit(Limit, Module, Reading, Value, Test, L, R),
    Value = quantity(V, S, _),
    Below is V - L,
    Var is S + R.
region(at_most(Limit), Module, Reading, Value, Test, region(one(above, Above, Var), at_most(H), sharp)) :-
    limit(Limit, Module, Reading, Value, Test, H, Q),
    Value = quantity(V, S, _),
    Above is H - V,
    Var is S + Q.
region(fading(Bounds, Width), Module, Reading, Value, Test, region(Margins, Within, width(W))) :-
    region(Bounds, Module, Reading, Value, Test, region(Margins0, Within, _)),
    limit(Width, Module, Reading, Value, Test, W0, Q),
    W is max(0, W0),
    widened(Margins0, W, Q, Margins).
region(soft(Bounds, Share), Module, Reading, Value, Test, region(Margins, Within, soft(W))) :-
    region(Bounds, Module, Reading, Value, Test, region(Margins, Within, _)),
    scale_of(Within, Scale),
    W is 2*Share*Scale.

%   Margins are measured from the middle of slopes that are Width wide, with the Variance of that.
widened(one(Side, D0, V0), Width, Q, one(Side, D, V)) :-
    D is D0 + Width/2,
    V is V0 + Q/4.
widened(two(B0, BV0, A0, AV0), Width, Q, two(B, BV, A, AV)) :-
    B is B0 + Width/2,
    BV is BV0 + Q/4,
    A is A0 + Width/2,
    AV is AV0 + Q/4.

limit(Expression, Module, Reading, Value, Test, V, Var) :-
    value(Expression, Module, Reading, Limit),
    comparable(Test, Value, Limit),
    Limit = quantity(V, Var, _).

                 /*******************************
                 *            STATES            *
                 *******************************/

%   judged(Want, Region, Measure, Said)
judged(state, Region, Measure, said(State, none)) :-
    nearest(Region, Side, Distance, _),
    (   Distance < 0
    ->  outside(Side, Measure, State)
    ;   Region = region(Margins, _, Edges),
        inside(Edges, Margins, State)
    ).
judged(full, Region, Measure, said(State, degree(Low, High, Miss))) :-
    degree_of(Region, Degree),
    nearest(Region, Side, Distance, Var),
    (   Distance < 0
    ->  outside(Side, Measure, State),
        (   State == fails
        ->  Low = Degree,
            High = Degree,
            miss(Region, Distance, Var, Miss)
        ;   Low = 0, High = 1, Miss = 0
        )
    ;   Region = region(Margins, _, Edges),
        inside_to(Edges, Margins, Degree, State),
        Low = Degree,
        High = Degree,
        Miss = 0
    ).

%   More of a thing may be there than was seen: too few is not known to be too few.
outside(Side, Measure, State) :-
    (   static(so_far(Measure)),
        Side == below
    ->  State = unknown
    ;   State = fails
    ).

%   What is counted of that which was seen.
so_far(Measure) :-
    nonvar(Measure),
    memberchk(Measure, [count(_), faces_at(_)]).

%   A value inside a region that it would more probably miss says nothing. One edge that does not fade
%   is missed by the lesser part of a distribution whose mean is inside.
inside(sharp, Margins, State) :-
    inside_limits(Margins, State).
inside(soft(_), Margins, State) :-
    inside_limits(Margins, State).
inside(width(Width), Margins, State) :-
    degree_within(width(Width), Margins, Degree),
    mostly(Degree, State).

inside_limits(one(_, _, _), holds).
inside_limits(two(Below, BelowVar, Above, AboveVar), State) :-
    mass_within(two(Below, BelowVar, Above, AboveVar), Degree),
    mostly(Degree, State).

%   The same where the Degree is known.
inside_to(sharp, _, Degree, State) :-
    mostly(Degree, State).
inside_to(width(_), _, Degree, State) :-
    mostly(Degree, State).
inside_to(soft(_), Margins, _, State) :-
    inside_limits(Margins, State).

%   A value in the middle of a slope is half inside, however that is rounded.
mostly(Degree, State) :-
    ( Degree < 0.5 - 1.0e-9 -> State = unknown ; State = holds ).

%   The edge that is nearest, or missed the most.
nearest(region(Margins, _, _), Side, Distance, Var) :-
    nearest_of(Margins, Side, Distance, Var).

nearest_of(one(Side, Distance, Var), Side, Distance, Var).
nearest_of(two(Below, BelowVar, Above, AboveVar), Side, Distance, Var) :-
    (   Above < Below
    ->  Side = above, Distance = Above, Var = AboveVar
    ;   Side = below, Distance = Below, Var = BelowVar
    ).

                 /*******************************
                 *            DEGREES           *
                 *******************************/

%   The probability, or expected membership, of the true value.
degree_of(region(Margins, _, Edges), Degree) :-
    degree_within(Edges, Margins, Degree).

degree_within(sharp, Margins, Degree) :-
    mass_within(Margins, Degree).
degree_within(width(Width), Margins, Degree) :-
    faded_within(Margins, Width, Degree).
degree_within(soft(Width), Margins, Degree) :-
    faded_within(Margins, Width, Degree).

faded_within(Margins, Width, Degree) :-
    (   crisp                           % without deviations nothing fades
    ->  mass_within(Margins, Degree)
    ;   membership_within(Margins, Width, Degree)
    ).

%   The mass between two edges is 1 less what lies beyond each.
mass_within(one(_, Distance, Var), Mass) :-
    mass(Distance, Var, Mass).
mass_within(two(Below, BelowVar, Above, AboveVar), Mass) :-
    mass(Below, BelowVar, FromBelow),
    mass(Above, AboveVar, FromAbove),
    Mass is max(0.0, FromBelow + FromAbove - 1).

%   r/(1 + r) of the distance r from the region, relative to the region's tolerance, half width or
%   limit (or to the deviation, where that is more): a miss by a tolerance is a half.
miss(region(_, Within, Width), Distance, Var, Miss) :-
    scale_of(Within, Scale0),
    widened_scale(Width, Scale0, Scale1),
    Scale is max(Scale1, sqrt(Var)),
    (   Scale > 0
    ->  Miss is -Distance/(Scale - Distance)
    ;   Miss = 1
    ).

scale_of(near(_, Tolerance), Scale)   :- Scale is abs(Tolerance).
scale_of(between(Low, High), Scale)   :- Scale is abs(High - Low)/2.
scale_of(at_least(Limit), Scale)      :- Scale is abs(Limit).
scale_of(at_most(Limit), Scale)       :- Scale is abs(Limit).

widened_scale(sharp, Scale, Scale).
widened_scale(soft(_), Scale, Scale).
widened_scale(width(Width), Scale0, Scale) :-
    Scale is Scale0 + Width/2.

                 /*******************************
                 *            DETAILS           *
                 *******************************/

%!  compared_in_detail(+Measure, +Bounds, +Module, +Test, -Said, -Detail) is det.
%
%   As compared/6 in full, with what a proof keeps of it (prove.pl).

compared_in_detail(Measure, Bounds, Module, Test, Said, Detail) :-
    (   hangs_on_space(Test, Measures),
        any_open(Measures)
    ->  compared_in_detail_as(free, Measure, Bounds, Module, Test, SaidFree, IfFree),
        compared_in_detail_as(full, Measure, Bounds, Module, Test, SaidFull, IfFull),
        either_way(full, SaidFree, SaidFull, Said),
        either_detail(IfFree, IfFull, Detail)
    ;   compared_in_detail_as(stated, Measure, Bounds, Module, Test, Said, Detail)
    ).

%   A limit that is not known is not known whatever was not seen. Else that case is shown which is nearer
%   to failing.
either_detail(missing(Missing, Cause), _, missing(Missing, Cause)) :- !.
either_detail(_, missing(Missing, Cause), missing(Missing, Cause)) :- !.
either_detail(IfFree, IfFull, unseen(Free, Full, Detail)) :-
    arg(1, IfFree, Free),
    arg(1, IfFull, Full),
    arg(5, IfFree, margin(_, FreeDistance, _)),
    arg(5, IfFull, margin(_, FullDistance, _)),
    ( FullDistance < FreeDistance -> Detail = IfFull ; Detail = IfFree ).

compared_in_detail_as(Reading, Measure, Bounds, Module, Test, Said, Detail) :-
    (   value(Measure, Module, Reading, Quantity),
        region(Bounds, Module, Reading, Quantity, Test, Region)
    ->  judged(full, Region, Measure, Said),
        Said = said(State, _),
        Quantity = quantity(V, Var, Kind),
        nearest(Region, Side, Distance, MarginVar),
        Sd is sqrt(Var),
        MarginSd is sqrt(MarginVar),
        Region = region(_, Within0, Edges),
        within(Edges, Within0, Within),
        Margin = margin(Side, Distance, MarginSd),
        (   State == unknown
        ->  Detail = uncertain(V, Sd, Kind, Within, Margin)
        ;   Detail = compared(V, Sd, Kind, Within, Margin)
        )
    ;   plain(full, unknown, Said),
        limits(Bounds, Limits),
        first_unknown([Measure|Limits], Module, Reading, Missing),
        missing_because(Missing, Cause),
        Detail = missing(Missing, Cause)
    ).

within(sharp, Within, Within).
within(width(Width), Within, fading(Within, Width)).
within(soft(Width), Within, soft(Within, Width)).

limits(fading(Bounds, Width), [Width|Limits]) :-
    !,
    limits(Bounds, Limits).
limits(soft(Bounds, _), Limits) :-
    !,
    limits(Bounds, Limits).
limits(Bounds, Limits) :-
    Bounds =.. [_|Limits].
