:- module(facetlog_compare, [ comparison/3,   % ?Test, ?Measure, ?Bounds
                              compare/5,      % +Measure, +Bounds, +Module, +Test, -Compared
                              compare_value/6, % +Quantity, +Measure, +Bounds, +Module, +Test, -Compared
                              judged/4,       % +Compared, -State, -Low, -High
                              detail/3,       % +Compared, +State, -Detail
                              miss/2          % +Compared, -Miss
                            ]).

/** <module> Measured values against their limits

A quantity and its limits become margins, and margins a state with its probability. evaluate.pl says
what is done with it.
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(fading)).
:- use_module(facetlog(vocabulary)).

% Arithmetic is most of the work: compiled, it takes half the time. The flag ends with the file.
:- set_prolog_flag(optimise, true).

                 /*******************************
                 *          COMPARISONS         *
                 *******************************/

%!  comparison(?Test, ?Measure, ?Bounds) is nondet.
%
%   Test compares Measure with Bounds, whose arguments are expressions.

comparison(near(M, Target, Tolerance), M, near(Target, Tolerance)).
comparison(between(M, Low, High), M, between(Low, High)).
comparison(at_least(M, Limit), M, at_least(Limit)).
comparison(at_most(M, Limit), M, at_most(Limit)).
comparison(fading(Test, Width), M, fading(Bounds, Width)) :-
    nonvar(Test),
    Test \= fading(_, _),
    comparison(Test, M, Bounds).

%!  compare(+Measure, +Bounds, +Module, +Test, -Compared) is det.
%
%   Compared is compared(Quantity, Measure, Margins, Within, Degree) or missing(Measure). Margins
%   are the signed distances, with variance, to the region's edges; inside all are >= 0. An edge that
%   fades is told from the middle of its slope, where the membership is 1/2.
%
%   @error type_error(comparable, Test) if a length is compared with a bare number, or the like.

compare(Measure, Bounds, Module, Test, Compared) :-
    (   value(Measure, Module, Value),
        compare_value(Value, Measure, Bounds, Module, Test, Compared0)
    ->  Compared = Compared0
    ;   limits(Bounds, Limits),
        first_unknown([Measure|Limits], Module, Missing),
        Compared = missing(Missing)
    ).

limits(fading(Bounds, Width), [Width|Limits]) :-
    !,
    limits(Bounds, Limits).
limits(Bounds, Limits) :-
    Bounds =.. [_|Limits].

%!  compare_value(+Quantity, +Measure, +Bounds, +Module, +Test, -Compared) is semidet.
%
%   The same where the Quantity of Measure is known. Fails if a limit is not.

compare_value(Value, Measure, Bounds, Module, Test,
              compared(Value, Measure, Margins, Within, Degree)) :-
    region(Bounds, Module, Value, Test, Margins, Within),
    (   Within = fading(_, Width),
        \+ crisp
    ->  membership_within(Margins, Width, Degree)
    ;   mass_within(Margins, 1, Degree)
    ).

%!  judged(+Compared, -State, -Low, -High) is det.

judged(missing(_), unknown, 0, 1).
judged(compared(_, Measure, Margins, _, Degree), State, Low, High) :-
    least_margin(Margins, margin(Side, Distance, _)),
    outcome(Measure, Side, Distance, Degree, State, Low, High).

%!  detail(+Compared, +State, -Detail) is det.
%
%   What a proof keeps of the comparison, see evaluate.pl.

detail(missing(Measure), _, missing(Measure, Cause)) :-
    missing_because(Measure, Cause).
detail(compared(quantity(V, Var, Kind), _, Margins, Within, _), State, Detail) :-
    least_margin(Margins, margin(Side, Distance, MarginVar)),
    Sd is sqrt(Var),
    MarginSd is sqrt(MarginVar),
    Margin = margin(Side, Distance, MarginSd),
    (   State == unknown
    ->  Detail = uncertain(V, Sd, Kind, Within, Margin)
    ;   Detail = compared(V, Sd, Kind, Within, Margin)
    ).

%   A value inside a region that it would more probably miss says nothing. And more of a thing may
%   be there than was seen: too few is not known to be too few.
outcome(Measure, Side, Distance, Degree, State, Low, High) :-
    (   Distance < 0
    ->  (   Side == below,
            so_far(Measure)
        ->  State = unknown, Low = 0, High = 1
        ;   State = fails, Low = Degree, High = Degree
        )
    ;   Degree < 0.5
    ->  State = unknown, Low = Degree, High = Degree
    ;   State = holds, Low = Degree, High = Degree
    ).

%   What is counted of that which was seen.
so_far(Measure) :-
    nonvar(Measure),
    memberchk(Measure, [count(_), faces_at(_)]).

region(near(Target, Tolerance), Module, Value, Test, Margins, near(T, W)) :-
    limit(Target, Module, Value, Test, T, R),
    limit(Tolerance, Module, Value, Test, W, Q),
    Value = quantity(V, S, _),
    Var is S + R + Q,
    Below is V - T + W,
    Above is T + W - V,
    Margins = [margin(below, Below, Var), margin(above, Above, Var)].
region(between(Low, High), Module, Value, Test, Margins, between(L, H)) :-
    limit(Low, Module, Value, Test, L, R),
    limit(High, Module, Value, Test, H, Q),
    Value = quantity(V, S, _),
    Below is V - L,
    BelowVar is S + R,
    Above is H - V,
    AboveVar is S + Q,
    Margins = [margin(below, Below, BelowVar), margin(above, Above, AboveVar)].
region(at_least(Limit), Module, Value, Test, [margin(below, Below, Var)], at_least(L)) :-
    limit(Limit, Module, Value, Test, L, R),
    Value = quantity(V, S, _),
    Below is V - L,
    Var is S + R.
region(at_most(Limit), Module, Value, Test, [margin(above, Above, Var)], at_most(H)) :-
    limit(Limit, Module, Value, Test, H, Q),
    Value = quantity(V, S, _),
    Above is H - V,
    Var is S + Q.

region(fading(Bounds, Width), Module, Value, Test, Margins, fading(Within, W)) :-
    region(Bounds, Module, Value, Test, Margins0, Within),
    limit(Width, Module, Value, Test, W0, Q),
    W is max(0, W0),
    widened(Margins0, W, Q, Margins).

limit(Expression, Module, Value, Test, V, Var) :-
    value(Expression, Module, Limit),
    comparable(Test, Value, Limit),
    Limit = quantity(V, Var, _).

least_margin([Margin], Margin) :-
    !.
least_margin([margin(S1, D1, V1), margin(S2, D2, V2)], Least) :-
    (   D2 < D1
    ->  Least = margin(S2, D2, V2)
    ;   Least = margin(S1, D1, V1)
    ).

%   The mass between two edges is 1 less what lies beyond each.
mass_within([], Sum, Mass) :-
    Mass is max(0.0, min(1.0, Sum)).
mass_within([margin(_, Distance, Var)|Margins], Sum0, Mass) :-
    mass(Distance, Var, M),
    Sum is Sum0 + M - 1,
    mass_within(Margins, Sum, Mass).

%!  miss(+Compared, -Miss) is det.
%
%   r/(1 + r) of the distance r from the region, relative to the region's tolerance, half width or
%   limit (or to the deviation, where that is more): a miss by a tolerance is a half.
miss(Compared, Miss) :-
    Compared = compared(_, _, Margins, Within, _),
    least_margin(Margins, margin(_, Margin, Var)),
    scale_of(Within, Scale0),
    Scale is max(Scale0, sqrt(Var)),
    (   Scale > 0
    ->  Miss is -Margin/(Scale - Margin)
    ;   Miss = 1
    ).

scale_of(near(_, Tolerance), Scale)   :- Scale is abs(Tolerance).
scale_of(between(Low, High), Scale)   :- Scale is abs(High - Low)/2.
scale_of(at_least(Limit), Scale)      :- Scale is abs(Limit).
scale_of(at_most(Limit), Scale)       :- Scale is abs(Limit).
scale_of(fading(Within, Width), Scale) :-
    scale_of(Within, Scale0),
    Scale is Scale0 + Width/2.
