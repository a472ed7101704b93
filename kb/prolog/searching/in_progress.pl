:- module(facetlog_in_progress, [ while_judging/4,   % +Module, +Model, +Thing, :Goal
                                 noted/3,           % +Module, +Model, +Thing
                                 being_judged/3,    % +Module, +Model, +Thing
                                 unless_cyclic/2    % :Goal, -Cyclic
                               ]).

/** <module> Which verdicts are being worked out

A model may ask what another one says of a thing, and that one in turn. What is being judged already
is not judged within itself; what was found in such a circle is true of that question only, and must
not be remembered.
*/

:- use_module(library(lists)).

:- meta_predicate while_judging(+, +, +, 0), unless_cyclic(0, -).

%!  while_judging(+Module, +Model, +Thing, :Goal) is semidet.
%
%   Goal, once, while Model is judged for Thing. What is noted already is not noted again, so that
%   who asks many goals notes it first.

while_judging(Module, Model, Thing, Goal) :-
    judged_now(Before),
    (   noted(Module, Model, Thing)
    ->  call(Goal)
    ;   b_setval(facetlog_judged, [judged(Module, Model, Thing)|Before]),
        call(Goal),
        b_setval(facetlog_judged, Before)
    ),
    !.

%!  noted(+Module, +Model, +Thing) is semidet.
%
%   It is what is being judged, within whatever else is.

noted(Module, Model, Thing) :-
    nb_current(facetlog_judged, [judged(Module, Model, Thing)|_]).

judged_now(Judged) :-
    ( nb_current(facetlog_judged, Judged0) -> Judged = Judged0 ; Judged = [] ).

%!  being_judged(+Module, +Model, +Thing) is semidet.
%
%   It is being judged, and whoever asks depends on that.

being_judged(Module, Model, Thing) :-
    judged_now(Judged),
    append(_, [judged(Module0, Model0, Thing0)|Below], Judged),
    Module0 == Module,
    Model0 == Model,
    Thing0 == Thing,
    !,
    length(Below, Depth),
    reach(Depth).

%!  unless_cyclic(:Goal, -Cyclic) is semidet.
%
%   Goal, once. Cyclic is true if something within it depended on what was being judged before, else
%   false.

unless_cyclic(Goal, Cyclic) :-
    judged_now(Judged),
    length(Judged, Depth),
    ( Depth =:= 0 -> Before = inf ; reached(Before) ),
    nb_setval(facetlog_reached, inf),
    ( call(Goal) -> Found = true ; Found = false ),
    reached(Lowest),
    ( Lowest < Depth -> Cyclic = true ; Cyclic = false ),
    nb_setval(facetlog_reached, Before),
    ( Cyclic == true -> reach(Lowest) ; true ),
    Found == true.

%   The least depth that was asked for; nothing of it may be undone by backtracking.
reached(Depth) :-
    ( nb_current(facetlog_reached, Depth0) -> Depth = Depth0 ; Depth = inf ).

reach(Depth) :-
    reached(Before),
    ( Depth < Before -> nb_setval(facetlog_reached, Depth) ; true ).
