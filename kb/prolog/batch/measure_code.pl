:- module(facetlog_measure_code, [ value_code/6,      % +Expression, +Context, -Code, -V, -Var, -Kind
                                   comparison_code/5, % +Measure, +Bounds, +Context, -Code, -Margins
                                   compared_code/4,   % +Margins, +Measure, -Code, -Outline
                                   known_measure_code/6, % +Measure, -V, -Sd, -Kind, +Context, -Code
                                   so_far_measure/1   % +Measure
                                 ]).

/** <module> Measures and limits into arithmetic

The same arithmetic as quantities.pl and compare.pl do, term for term, so that not a digit differs.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(outlines)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog(measures)).
:- use_module(facetlog(vocabulary)).

%!  value_code(+Expression, +Context, -Code, -V, -Var, -Kind) is semidet.
%
%   Code works out the value V and its variance Var, or fails where the scene does not know. Kind is
%   as in quantities.pl. Fails for an expression whose kind is not known beforehand.

value_code(X, _, _, _, _, _) :-
    var(X),
    !,
    fail.
value_code(X, _, true, X, 0, number) :-
    number(X),
    !.
value_code(tolerance(Name), context(Module, _, _), true, X, 0, number) :-
    !,
    named_tolerance(Name, Module, X),
    number(X).
value_code(-A, Context, ( Code, V is -X ), V, Var, Kind) :-
    !,
    value_code(A, Context, Code, X, Var, Kind).
value_code(A + B, Context, ( CodeA, CodeB, V is X + Y, Var is SX + SY ), V, Var, Kind) :-
    !,
    two(A, B, Context, CodeA, CodeB, X, SX, Kind, Y, SY, KindB),
    alike(Kind, KindB).
value_code(A - B, Context, ( CodeA, CodeB, V is X - Y, Var is SX + SY ), V, Var, Kind) :-
    !,
    two(A, B, Context, CodeA, CodeB, X, SX, Kind, Y, SY, KindB),
    alike(Kind, KindB).
value_code(A * B, Context, ( CodeA, CodeB, Product, Var is Y*Y*SX + X*X*SY ), V, Var, Kind) :-
    !,
    two(A, B, Context, CodeA, CodeB, X, SX, KX, Y, SY, KY),
    (   ( float(X) ; float(Y) )
    ->  Product = ( V is X*Y )
    ;   Product = facetlog_quantities:product(X, Y, V)
    ),
    dimension(KX, DX),
    dimension(KY, DY),
    D is DX + DY,
    kind(D, Kind).
value_code(A / B, Context, ( CodeA, CodeB, Y =\= 0, V is X/Y, Var is (SX + V*V*SY) / (Y*Y) ), V, Var,
           Kind) :-
    !,
    two(A, B, Context, CodeA, CodeB, X, SX, KX, Y, SY, KY),
    dimension(KX, DX),
    dimension(KY, DY),
    D is DX - DY,
    kind(D, Kind).
value_code(Measure, Context, Code, V, Var, Kind) :-
    Context = context(Module, _, Crisp),
    \+ own_measures(Module),
    findall(measure(Measure, V0, Sd0, Kind0, Body),
            clause(measures:measure(Measure, V0, Sd0, Kind0), Body),
            Found),
    Found = [_|_],
    maplist(kind_of(Kind), Found),
    nonvar(Kind),
    measure_code(Found, Measure, Context, Known, V, Sd),
    (   Crisp == true
    ->  Var = 0,
        Code = Known
    ;   Sd == 0
    ->  Var = 0,
        Code = Known
    ;   Code = ( Known, Var is Sd*Sd )
    ).

own_measures(Module) :-
    current_predicate(Module:measured/4).

kind_of(Kind, measure(_, _, _, Kind, _)).

two(A, B, Context, CodeA, CodeB, X, SX, KX, Y, SY, KY) :-
    value_code(A, Context, CodeA, X, SX, KX),
    value_code(B, Context, CodeB, Y, SY, KY).

%   Kinds that may be compared whatever their values are.
alike(Kind, Kind) :- !.
alike(KindA, KindB) :-
    dimension(KindA, D),
    dimension(KindB, D).

%   The first clause that knows it counts. What is not a plain fact is worked out once.
measure_code([measure(Measure, V, Sd, _, fact(Fact))], Measure, Context, Code, V, Sd) :-
    !,
    body_code(measures:fact(Fact), Context, Code).
measure_code([measure(Measure, V1, Sd1, _, fact(Fact))|Found], Measure, Context, Code, V, Sd) :-
    var(V1),
    var(Sd1),
    !,
    V1 = V,
    Sd1 = Sd,
    body_code(measures:fact(Fact), Context, First),
    measure_code(Found, Measure, Context, Rest, V, Sd2),
    Code = ( First -> true ; Rest, Sd = Sd2 ).
measure_code(Found, Measure, Context, Code, V, Sd) :-
    term_variables(Measure, Args),
    copy_term(Measure-Args, General-Generals),
    append(Generals, [V0, Sd0], HeadArgs),
    helper(Context, measure(General), HeadArgs, Head, New),
    (   New == true
    ->  findall(found(General, V1, Sd1, Body),
                ( member(measure(General, V1, Sd1, _, Body0), Found),
                  body_code(measures:Body0, Context, Body) ),
                Bodies),
        foldl(first_body(General, V0, Sd0), Bodies, fail, Any),
        put_remembered(Context, Head, Generals, [V0, Sd0], Any)
    ;   true
    ),
    append(Args, [V, Sd], CallArgs),
    Head =.. [Name|_],
    Code =.. [Name|CallArgs].

first_body(General, V, Sd, found(General, V1, Sd1, Body), Before,
           ( Before ; Body, V = V1, Sd = Sd1 )).

%!  known_measure_code(+Measure, -V, -Sd, -Kind, +Context, -Code) is semidet.
%
%   As measure/4 of the vocabulary, of which it is the first answer.

known_measure_code(Measure, V, Sd, Kind, Context, Code) :-
    callable(Measure),
    findall(measure(Measure, V0, Sd0, Kind0, Body),
            clause(measures:measure(Measure, V0, Sd0, Kind0), Body),
            Found),
    Found = [_|_],
    maplist(kind_of(Kind), Found),
    measure_code(Found, Measure, Context, Code, V, Sd).

named_tolerance(Name, Module, X) :-
    current_predicate(Module:tolerance/2),
    Module:tolerance(Name, X),
    !.
named_tolerance(Name, _, X) :-
    vocabulary:tolerance(Name, X).

%!  comparison_code(+Measure, +Bounds, +Context, -Code, -Margins) is semidet.
%
%   Code works out the Margins, or fails where the measure or a limit is not known. Margins is
%
%     - one(Side, Distance, Var, Scale);
%     - two(Below, BelowVar, Above, AboveVar, Scale);
%     - fading(Margins, Width).
%
%   Scale says what a miss is relative to: see miss/2.

comparison_code(Measure, fading(Bounds, Width0), Context, ( Code, WidthCode, Fading ), Margins) :-
    !,
    comparison_code(Measure, Bounds, Context, Code, Margins0),
    value_code(Measure, Context, _, _, _, Kind),
    value_code(Width0, Context, WidthCode, W0, Q, KindW),
    alike(Kind, KindW),
    faded(Margins0, W0, Q, Fading, Margins1),
    % Without deviations nothing fades: the middle of the slope is the edge.
    ( Context = context(_, _, true) -> Margins1 = fading(Margins, _) ; Margins = Margins1 ).
comparison_code(Measure, near(Target, Tolerance), Context,
                ( Code, CodeT, CodeW, Var is S + R + Q, Below is V - T + W, Above is T + W - V ),
                two(Below, Var, Above, Var, abs(W))) :-
    limits(Measure, [Target-CodeT-T-R, Tolerance-CodeW-W-Q], Context, Code, V, S).
comparison_code(Measure, between(Low, High), Context,
                ( Code, CodeL, CodeH, Below is V - L, BelowVar is S + R,
                  Above is H - V, AboveVar is S + Q ),
                two(Below, BelowVar, Above, AboveVar, abs(H - L)/2)) :-
    limits(Measure, [Low-CodeL-L-R, High-CodeH-H-Q], Context, Code, V, S).
comparison_code(Measure, at_least(Limit), Context, ( Code, CodeL, Below is V - L, Var is S + R ),
                one(below, Below, Var, abs(L))) :-
    limits(Measure, [Limit-CodeL-L-R], Context, Code, V, S).
comparison_code(Measure, at_most(Limit), Context, ( Code, CodeL, Above is L - V, Var is S + R ),
                one(above, Above, Var, abs(L))) :-
    limits(Measure, [Limit-CodeL-L-R], Context, Code, V, S).

limits(Measure, Limits, Context, Code, V, S) :-
    value_code(Measure, Context, Code, V, S, Kind),
    maplist(limit_code(Context, Kind), Limits).

limit_code(Context, Kind, Limit-Code-V-Var) :-
    value_code(Limit, Context, Code, V, Var, LimitKind),
    (   alike(Kind, LimitKind)
    ->  true
    ;   V == 0                          % may be compared with anything
    ).

faded(one(Side, D0, V0, Scale), W0, Q,
      ( W is max(0, W0), D is D0 + W/2, Var is V0 + Q/4 ),
      fading(one(Side, D, Var, Scale + W/2), W)).
faded(two(B0, BV0, A0, AV0, Scale), W0, Q,
      ( W is max(0, W0), B is B0 + W/2, BV is BV0 + Q/4, A is A0 + W/2, AV is AV0 + Q/4 ),
      fading(two(B, BV, A, AV, Scale + W/2), W)).

%!  compared_code(+Margins, +Measure, -Code, -Outline) is det.
%
%   What the margins come to, see outlines.pl.

compared_code(Margins, Measure, Code, Outline) :-
    ( so_far_measure(Measure) -> SoFar = true ; SoFar = false ),
    Outline = outline(S, L, H, Miss),
    Code0 = facetlog_outlines:compared(Margins1, SoFar, S, L, H, Miss),
    scaled(Margins, Margins1, ScaleCode),
    Code = ( ScaleCode, Code0 ).

scaled(one(Side, D, Var, Scale0), one(Side, D, Var, Scale), Scale is Scale0).
scaled(two(B, BV, A, AV, Scale0), two(B, BV, A, AV, Scale), Scale is Scale0).
scaled(fading(Margins0, W), fading(Margins, W), Code) :- scaled(Margins0, Margins, Code).

%!  so_far_measure(+Measure) is semidet.
%
%   It counts what was seen: too few is not known to be too few.

so_far_measure(count(_)).
so_far_measure(faces_at(_)).

dimension(length, 1) :- !.
dimension(area, 2) :- !.
dimension(power(D), D) :- !.
dimension(_, 0).

kind(0, ratio) :- !.
kind(1, length) :- !.
kind(2, area) :- !.
kind(D, power(D)).
