:- module(facetlog_seen_parts, [ as_far_as_seen_in/4,    % +Module, +Thing, +Steps, -Parts
                                seen_parts/2            % +Steps, +Faces
                               ]).

/** <module> Faces for parts, as far as a thing was seen

What joins propose needs all parts to be there. Where one was not seen, the others are chosen one
after the other, the largest first, and what lacks is written `unseen`: such proposals make near
misses and leave a model open.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(library(solution_sequences)).
:- use_module(facetlog(vocabulary)).

%   As many as a near miss needs; each is judged.
most_choices(60).

%!  as_far_as_seen_in(+Module, +Thing, +Steps, -Parts) is nondet.
%
%   As as_far_as_seen/3 of the vocabulary; words and tolerances of the tests are those of Module.
%
%   @error type_error(step, Step) for what is no step(Variable, Count, Test), or a Test that names a
%          module.

as_far_as_seen_in(Module, Thing, Steps, Parts) :-
    must_be(list, Steps),
    parts_of(Steps, Parts),
    maplist(step_goal(Module), Steps, Goals),
    largest_faces(Thing, Faces),
    seen_parts(Goals, Faces).

step_goal(Module, step(Part, Count, Test), step(Part, Count, vocabulary:possible(Module:Test))).

%!  seen_parts(+Steps, +Faces) is nondet.
%
%   Binds the variables of Steps to some of Faces, the largest first. Steps is a list of
%   step(Variable, Count, Goal), where Goal says whether what it is bound to fits.

seen_parts(Steps, Faces) :-
    most_choices(Most),
    limit(Most, chosen(Steps, Faces, [])).

parts_of([], []).
parts_of([Step|Steps], [Part|Parts]) :-
    (   nonvar(Step),
        Step = step(Part0, Count, Test),
        var(Part0),
        nonvar(Test),
        Test \= _:_
    ->  must_be(nonneg, Count),
        Part = Part0
    ;   type_error(step, Step)
    ),
    parts_of(Steps, Parts).

chosen([], _, _).
chosen([step(Part, Count, Goal)|Steps], Faces, Used) :-
    findall(Face,
            limit(Count, ( member(Face, Faces),
                           \+ memberchk(Face, Used),
                           \+ \+ ( Part = Face, call(Goal) ) )),
            Fitting),
    (   Fitting == []
    ->  Part = unseen
    ;   member(Part, Fitting)
    ),
    chosen(Steps, Faces, [Part|Used]).
